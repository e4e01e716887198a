"""A second way to film an arm, which shares no code with the first (`samples.generator`) nor with the packages.

Its optics are a disc of defocus on a raster four times as fine, its sensor has coloured pixels, shot noise, a tone curve and a
sharpener, and its files are of any codec. What the fit of markers takes for granted (a Gaussian blur, straight grey levels)
does not hold in it.
"""
