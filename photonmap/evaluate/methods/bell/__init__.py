"""Bell's random field: pixels that are alike, wherever they are, share few reflectances.

S. Bell, K. Bala and N. Snavely, "Intrinsic images in the wild", SIGGRAPH 2014. Each pixel has one
of 20 reflectances R_x, cluster means of the image's intensity (times 0.5) and chromaticity; its
shading is grey, s_i = |I_i| / |R_x|, with |·| the mean over bands. The energy of labels x is

    E(x) = w_p Σ_{i<j} ψ_ij + w_s Σ_i ψ_i + w_l Σ_i λ_i
    ψ_ij = |log R_xi − log R_xj|_1 exp(−|f_i − f_j|² / 2)
    f_i = (position / (θ_p d), |I_i| / θ_l, chromaticity / θ_c)
    ψ_i = (log s_i − log s̄_i)²,  λ_i = |log s_i − log ½|

over all pairs of pixels, d being the image's diagonal. s̄ is the shading of the round before,
blurred by 0.1 d / round; the first round has no ψ_i. Rounds have two stages. (1) Ten steps of mean
field, in which the kernel is filtered on a permutohedral lattice and normalised symmetrically
(Krähenbühl and Koltun 2013), lower E. (2) With labels held, the intensities of reflectances
change to lower Σ |log s_i − log s_j| over neighbours whose labels differ; in the last round each
connected region has an intensity of its own.

Weights are those that the authors state for their best result on their photographs: 25 rounds,
w_p = 10000, w_s = 20000, w_l = 500, θ_p = θ_l = 0.1, θ_c = 0.025. Left open, and chosen here:
chromaticity is that of all bands, C − 1 of them; the 99th percentile
of intensity is 1; clusters start from splits at medians; stage 2
is solved by ten rounds of reweighted least squares and keeps the median of log reflectance; mean
field stops early where no probability moves by 0.001.
"""

from photonmap.evaluate.methods.bell.estimate import METHOD

__all__ = ["METHOD"]
