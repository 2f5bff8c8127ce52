"""SIRFS: the most likely shape, reflectance and light that explain a shaded image.

J. T. Barron and J. Malik, "Color constancy, intrinsic images, and shape estimation", ECCV 2012,
and for what it builds on "Shape, albedo, and illumination from a single image of an unknown
object", CVPR 2012. For a log image I, depth Z and light L,

    minimise g(I − S(Z, L)) + f(Z) + h(L)                      (1)

S, the log shading, is linear in the spherical harmonics of normals up to order 2, with nine
coefficients for each band. The priors:

- reflectance g: differences in windows of 5×5 pixels come from a Gaussian scale mixture; few
  values occur (Rényi's quadratic entropy); values themselves are likely or not
- shape f: differences of mean curvature in windows of 5×5 come from a Gaussian scale mixture;
  surfaces face the camera
- light h: coefficients are normally distributed

L-BFGS descends in a pyramid of Z and in L.

What differs. The priors were learnt on scenes of this data set's kind with other seeds (`learn`),
not on those of Grosse et al. Bands are exchangeable, so that any number of them will do: the
brightness of a colour, its mean over bands, and its deviations from that have one variance each,
and so have the coefficients of light; values of reflectance are normal instead of splines over
colours; the entropy is that of a grid of pixels instead of all. There is no term for occluding
contours, as these images are not of one object on nothing. Of the four weights a few values were
tried on seven images of the scenes of the priors; the paper's come from a search.
"""
