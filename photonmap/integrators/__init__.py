"""The passes: photons, radiosity cache, caustics, sampling plan, camera pass, render loop."""
