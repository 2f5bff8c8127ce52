"""Names and shades of colour: pixels that share one of them share reflectance. Our reading.

M. Serra, O. Penacchio, R. Benavente and M. Vanrell, "Names and shades of color for intrinsic image
estimation", CVPR 2012. Only the abstract of this paper could be read. It says that two descriptors
of surfaces, the name of a colour and its shade, the latter "capturing gradual color surface
variations" that follow from how images form, are combined in a Markov random field. Both
descriptors were published before by the same group, and are built from there:

- names: the parametric fuzzy sets of Benavente, Vanrell and Baldrich 2008 (`names`)
- shades: ridges of the histogram of colours, by Vazquez et al. 2011 (`ridges`)

How the field combines them is ours. With l = log I of grey values, log reflectance r minimises

    E(r, ρ) = Σ_{i~j} (r_i − r_j − (1 − a_ij) (l_i − l_j))² + λ Σ_i Σ_n μ_n(i) (r_i − ρ_{k(i),n})²
    a_ij = 1 if k(i) = k(j), else Σ_n min(μ_n(i), μ_n(j))

over neighbours i ~ j, the ridge k(i) of a pixel, and its memberships μ_n(i) in names n, which add
up to 1. Neighbours on one ridge, or of one name, have one reflectance, and what differs is shading;
for others, what differs is reflectance. All pixels of the image that share both ridge and name are
tied to one reflectance ρ, which is the same as to tie each two of them with weights
λ μ_n(i) μ_n(j) / Σ μ_n. Shading is grey. E is quadratic: its field is Gaussian, and a sparse linear
system gives its most likely state.

λ and the settings of ridges were chosen by LMSE on scenes with other seeds, in white light and in
that of two bulbs. Of other bands than RGB, thirds are averaged to blue, green and red. What this
method scores is not what the authors' code would.
"""

from photonmap.evaluate.methods.serra.estimate import METHOD

__all__ = ["METHOD"]
