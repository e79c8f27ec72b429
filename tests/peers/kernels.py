"""Times what other programs take for the work of the pixel kernels, one thread each.

Prints one line a measurement, fields separated by tabs: peer, work, milliseconds (the fastest of
many runs); or peer, `not installed`. Run by `cargo xtask bench`; needs python3 with numpy, and
measures what it finds of GDAL (osgeo) and OpenCV (cv2).
"""

import time

SIDE = 256
"""Samples along a side of a tile."""


def fastest_ms(work, seconds=2.0):
    """Milliseconds of the fastest of many runs of `work`, after one that warms caches."""
    work()
    fastest = float("inf")
    end = time.perf_counter() + seconds
    while time.perf_counter() < end:
        start = time.perf_counter()
        work()
        fastest = min(fastest, time.perf_counter() - start)
    return fastest * 1e3


def report(peer, work, milliseconds):
    print(f"{peer}\t{work}\t{milliseconds:.4f}", flush=True)


def gdal_peer():
    """The windows of `core/raster/benches/warp.rs` and the shading of heights."""
    try:
        import numpy
        from osgeo import gdal, osr
    except ImportError:
        print("GDAL\tnot installed")
        return
    gdal.UseExceptions()
    gdal.SetConfigOption("GDAL_NUM_THREADS", "1")
    gdal.SetCacheMax(256 << 20)
    peer = f"GDAL {gdal.__version__}"

    # The same file: 2048² pixels of 30 m in UTM zone 12 around (457000, 4483000), tiled.
    side = 2048
    columns, rows = numpy.meshgrid(numpy.arange(side), numpy.arange(side))
    heights = (numpy.sin(columns * 0.1) * 300.0 + rows).astype(numpy.float32)
    utm = osr.SpatialReference()
    utm.ImportFromEPSG(32612)
    half_m = side * 15.0
    path = "/vsimem/utm.tif"
    file = gdal.GetDriverByName("GTiff").Create(
        path, side, side, 1, gdal.GDT_Float32, ["TILED=YES", "COMPRESS=DEFLATE"]
    )
    file.SetProjection(utm.ExportToWkt())
    file.SetGeoTransform([457000.0 - half_m, 30.0, 0.0, 4483000.0 + half_m, 0.0, -30.0])
    file.GetRasterBand(1).WriteArray(heights)
    file.FlushCache()
    file = gdal.Open(path)
    # Decoded tiles stay in GDAL's cache of blocks.
    file.GetRasterBand(1).ReadAsArray()

    # The tile of 2^13 × 2^12 tiles around the globe that holds (-111.5, 40.5).
    level = 12
    step = 180.0 / (SIDE << level)
    column = int((-111.5 + 180.0) / step) // SIDE
    row = int((90.0 - 40.5) / step) // SIDE
    west, north = -180.0 + column * SIDE * step, 90.0 - row * SIDE * step
    bounds = [west, north - SIDE * step, west + SIDE * step, north]

    def warp(**options):
        gdal.Warp(
            "",
            file,
            format="MEM",
            dstSRS="EPSG:4326",
            outputBounds=bounds,
            width=SIDE,
            height=SIDE,
            resampleAlg="bilinear",
            **options,
        )

    report(peer, "warp, exact places (-et 0)", fastest_ms(lambda: warp(errorThreshold=0)))
    report(peer, "warp, default error (-et 0.125)", fastest_ms(warp))

    # The warper alone, on open files: without opening, naming and closing datasets.
    target = gdal.GetDriverByName("MEM").Create("", SIDE, SIDE, 1, gdal.GDT_Float32)
    geographic = osr.SpatialReference()
    geographic.ImportFromEPSG(4326)
    target.SetProjection(geographic.ExportToWkt())
    target.SetGeoTransform([west, step, 0.0, north, 0.0, -step])
    for name, error in [("exact places", 0.0), ("error 0.125", 0.125)]:
        report(
            peer,
            f"warp into an open file, {name}",
            fastest_ms(
                lambda: gdal.ReprojectImage(
                    file, target, None, None, gdal.GRA_Bilinear, 64 << 20, error
                )
            ),
        )

    memory = gdal.GetDriverByName("MEM").CreateCopy("", file)
    shade_ms = fastest_ms(
        lambda: gdal.DEMProcessing("", memory, "hillshade", format="MEM"), 4.0
    )
    # Of as many samples as a tile has.
    report(peer, "hillshade, a tile's share of 2048²", shade_ms * (SIDE * SIDE) / side**2)


def opencv_peer():
    """Brightness, contrast, hue, saturation and gamma of an RGBA tile, in floats."""
    try:
        import cv2
        import numpy
    except ImportError:
        print("OpenCV\tnot installed")
        return
    cv2.setNumThreads(1)
    peer = f"OpenCV {cv2.__version__}"
    tile = numpy.random.default_rng(1).integers(0, 256, (SIDE, SIDE, 4), numpy.uint8)
    brightness, contrast, hue_deg, saturation, gamma = 1.1, 1.2, 20.0, 0.8, 1.3

    def chain(with_gamma):
        rgb = cv2.cvtColor(tile, cv2.COLOR_RGBA2RGB)
        rgb = cv2.normalize(rgb, None, 0, 1, cv2.NORM_MINMAX, cv2.CV_32F)
        rgb = cv2.addWeighted(
            rgb, brightness * contrast, rgb, 0.0, 0.5 - 0.5 * contrast
        )
        hsv = cv2.cvtColor(rgb, cv2.COLOR_RGB2HSV)
        hue, sat, value = cv2.split(hsv)
        hue = cv2.add(hue, hue_deg)
        sat = cv2.multiply(sat, saturation)
        rgb = cv2.cvtColor(cv2.merge([hue, sat, value]), cv2.COLOR_HSV2RGB)
        if with_gamma:
            rgb = cv2.pow(cv2.max(rgb, 0.0), 1.0 / gamma)
        rgb = cv2.convertScaleAbs(rgb, alpha=255.0)
        return cv2.merge([*cv2.split(rgb), tile[:, :, 3]])

    # The same by one matrix for all but gamma, as ours is: the fastest way there is in OpenCV.
    matrix = numpy.array(
        [[1.1, 0.1, 0.1, -0.1], [0.1, 1.1, 0.1, -0.1], [0.1, 0.1, 1.1, -0.1]], numpy.float32
    )

    def by_matrix():
        rgb = cv2.cvtColor(tile, cv2.COLOR_RGBA2RGB).astype(numpy.float32)
        rgb = cv2.transform(rgb, matrix / 255.0)
        rgb = cv2.pow(cv2.max(rgb, 0.0), 1.0 / gamma)
        rgb = cv2.convertScaleAbs(rgb, alpha=255.0)
        return cv2.merge([*cv2.split(rgb), tile[:, :, 3]])

    report(peer, "adjust, without gamma", fastest_ms(lambda: chain(False)))
    report(peer, "adjust, with gamma", fastest_ms(lambda: chain(True)))
    report(peer, "adjust by one matrix, with gamma", fastest_ms(by_matrix))


if __name__ == "__main__":
    gdal_peer()
    opencv_peer()
