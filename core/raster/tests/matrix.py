#!/usr/bin/env python3
"""Compares the TIFF reader with GDAL, file by file and sample by sample.

Makes a matrix of files with GDAL's Python bindings (types, compressions, predictors, tilings, planes,
byte orders, overviews, masks) in a scratch folder, reads each with the example `samples` of this crate
and with GDAL, and prints a table: file, read, refused or wrong. Files given as further arguments are
compared too. Not a part of any build: the tests hold what matters of it as small fixtures.

    cargo build -p relievo-raster --example samples
    python3 core/raster/tests/matrix.py target/debug/examples/samples SCRATCH [FILE ...]
"""
import itertools
import os
import subprocess
import sys

import numpy as np
from osgeo import gdal, gdal_array

gdal.UseExceptions()
gdal.PushErrorHandler("CPLQuietErrorHandler")
gdal.SetConfigOption("GDAL_PAM_ENABLED", "NO")
W, H = 70, 53
TYPES = {"byte": gdal.GDT_Byte, "int8": gdal.GDT_Byte, "uint16": gdal.GDT_UInt16, "int16": gdal.GDT_Int16,
         "uint32": gdal.GDT_UInt32, "int32": gdal.GDT_Int32, "uint64": gdal.GDT_UInt64, "int64": gdal.GDT_Int64,
         "float32": gdal.GDT_Float32, "float64": gdal.GDT_Float64, "cint16": gdal.GDT_CInt16,
         "cfloat32": gdal.GDT_CFloat32}
RANGE = {"byte": (0, 255), "int8": (0, 127), "uint16": (0, 65535), "int16": (-32000, 32000),
         "uint32": (0, 4e9), "int32": (-2e9, 2e9), "uint64": (0, 1e15), "int64": (-1e15, 1e15),
         "float32": (-1e4, 1e4), "float64": (-1e4, 1e4), "cint16": (0, 100), "cfloat32": (0, 100)}


def wave(band, low, high):
    """A smooth surface with some noise, between two numbers."""
    y, x = np.mgrid[0:H, 0:W]
    v = 0.5 + 0.4 * np.sin(x * (0.07 + 0.02 * band)) * np.cos(y * 0.09) + 0.1 * np.modf(np.sin(x * 12.9 + y * 78.2 + band) * 43758.5)[0]
    return low + (high - low) * np.clip(v, 0, 1)


def memory(kind, bands, bits=None, place=True):
    low, high = RANGE[kind] if bits is None else (0, 2 ** bits - 1)
    mem = gdal.GetDriverByName("MEM").Create("", W, H, bands, TYPES[kind])
    if place:
        mem.SetProjection(utm())
        mem.SetGeoTransform([440000, 30, 0, 4485000, 0, -30])
    for b in range(bands):
        a = wave(b, low, high)
        if "float" not in kind:
            a = np.floor(a)
        mem.GetRasterBand(b + 1).WriteArray(a.astype(gdal_array.GDALTypeCodeToNumericTypeCode(TYPES[kind])))
    return mem


def picture(bands):
    mem = memory("byte", bands)
    roles = [gdal.GCI_RedBand, gdal.GCI_GreenBand, gdal.GCI_BlueBand, gdal.GCI_AlphaBand]
    for b in range(bands if bands > 1 else 0):
        mem.GetRasterBand(b + 1).SetColorInterpretation(roles[b])
    if bands == 4:
        alpha = mem.GetRasterBand(4).ReadAsArray()
        mem.GetRasterBand(4).WriteArray(np.where(alpha > 90, 255, 0).astype("u1"))
    return mem


def utm():
    from osgeo import osr
    srs = osr.SpatialReference()
    srs.ImportFromEPSG(32612)
    return srs.ExportToWkt()


def write(folder, name, source, options, **settings):
    """A GTiff copy; returns its path, or None where GDAL itself cannot write it."""
    path = os.path.join(folder, name + ".tif")
    if os.path.exists(path):
        for old in (path, path + ".ovr", path + ".msk", path + ".msk.ovr", path + ".aux.xml"):
            if os.path.exists(old):
                os.remove(old)
    for key, value in settings.items():
        gdal.SetConfigOption(key, value)
    try:
        gdal.GetDriverByName("GTiff").CreateCopy(path, source, options=options)
        return path
    except RuntimeError as error:
        print(f"# GDAL does not write {name}: {error}", file=sys.stderr)
        return None
    finally:
        for key in settings:
            gdal.SetConfigOption(key, None)


def make(folder):
    files = []

    def add(path):
        if path:
            files.append(path)

    tiled = ["TILED=YES", "BLOCKXSIZE=16", "BLOCKYSIZE=32"]
    # Types by compressions by predictors by layout.
    for kind in TYPES:
        for compress, predictor in itertools.product(["NONE", "LZW", "DEFLATE", "ZSTD", "PACKBITS", "LZMA", "LERC", "LERC_DEFLATE", "LERC_ZSTD"], [1, 2, 3]):
            if predictor > 1 and compress not in ("LZW", "DEFLATE", "ZSTD"):
                continue
            if predictor == 3 and "float" not in kind:
                continue
            if kind.startswith("c") and (compress not in ("NONE", "DEFLATE") or predictor > 1):
                continue
            for layout, planes in itertools.product(["tiles", "strips"], [(1, "PIXEL"), (3, "PIXEL"), (3, "BAND")]):
                for endian in ("LITTLE", "BIG"):
                    if endian == "BIG" and (compress.startswith("LERC_") or compress in ("PACKBITS", "LZMA")):
                        continue
                    options = [f"COMPRESS={compress}", f"INTERLEAVE={planes[1]}", f"ENDIANNESS={endian}"]
                    options += tiled if layout == "tiles" else ["BLOCKYSIZE=7"]
                    options += [f"PREDICTOR={predictor}"] if predictor > 1 else []
                    options += ["PIXELTYPE=SIGNEDBYTE"] if kind == "int8" else []
                    name = f"{kind}-{compress.lower()}-{predictor}-{layout}-{planes[0]}{planes[1].lower()}-{endian.lower()}"
                    add(write(folder, name, memory(kind, planes[0]), options))
    # Unusual bit depths.
    for bits in [1, 2, 3, 4, 5, 6, 7, 9, 10, 11, 12, 13, 14, 15, 17, 20, 24, 31]:
        kind = "byte" if bits < 8 else "uint16" if bits < 16 else "uint32"
        for compress, (bands, inter), layout in itertools.product(["NONE", "DEFLATE", "LZW"], [(1, "PIXEL"), (3, "PIXEL"), (3, "BAND")], ["tiles", "strips"]):
            for endian in ("LITTLE", "BIG"):
                options = [f"NBITS={bits}", f"COMPRESS={compress}", f"INTERLEAVE={inter}", f"ENDIANNESS={endian}"] + (tiled if layout == "tiles" else [])
                add(write(folder, f"bits{bits}-{compress.lower()}-{layout}-{bands}{inter.lower()}-{endian.lower()}", memory(kind, bands, bits), options))
    for bits in (16, 24):
        for compress, predictor in (("NONE", 1), ("DEFLATE", 1), ("DEFLATE", 2), ("DEFLATE", 3), ("LZW", 3), ("ZSTD", 3)):
            for endian in ("LITTLE", "BIG"):
                options = [f"NBITS={bits}", f"COMPRESS={compress}", f"ENDIANNESS={endian}"] + ([f"PREDICTOR={predictor}"] if predictor > 1 else []) + tiled
                add(write(folder, f"float{bits}-{compress.lower()}-{predictor}-{endian.lower()}", memory("float32", 1), options))
    # BigTIFF.
    for kind, compress, layout in itertools.product(["byte", "float32", "int64"], ["NONE", "DEFLATE", "LERC_ZSTD"], ["tiles", "strips"]):
        for endian in ("LITTLE", "BIG"):
            options = ["BIGTIFF=YES", f"COMPRESS={compress}", f"ENDIANNESS={endian}"] + (tiled if layout == "tiles" else [])
            add(write(folder, f"big-{kind}-{compress.lower()}-{layout}-{endian.lower()}", memory(kind, 1), options))
    # Photographic compressions.
    for bands, layout in itertools.product([1, 3, 4], ["tiles", "strips"]):
        shape = tiled if layout == "tiles" else ["BLOCKYSIZE=16"]
        for inter in ("PIXEL", "BAND"):
            add(write(folder, f"jpeg-{bands}{inter.lower()}-{layout}", picture(bands), ["COMPRESS=JPEG", "JPEG_QUALITY=90", f"INTERLEAVE={inter}"] + shape))
        if bands == 3:
            add(write(folder, f"jpeg-ycbcr-{layout}", memory("byte", 3), ["COMPRESS=JPEG", "PHOTOMETRIC=YCBCR", "JPEG_QUALITY=90"] + shape))
            add(write(folder, f"jpeg-ycbcr-big-{layout}", memory("byte", 3), ["COMPRESS=JPEG", "PHOTOMETRIC=YCBCR", "JPEG_QUALITY=90", "ENDIANNESS=BIG"] + shape))
        if bands > 1:
            for lossless in ("YES", "NO"):
                add(write(folder, f"webp-{bands}-{layout}-{lossless.lower()}", picture(bands), ["COMPRESS=WEBP", f"WEBP_LOSSLESS={lossless}", "WEBP_LEVEL=95"] + (tiled if layout == "tiles" else [])))
    # Lossy LERC.
    for kind in ("byte", "int16", "float32", "float64"):
        for compress in ("LERC", "LERC_DEFLATE", "LERC_ZSTD"):
            add(write(folder, f"{compress.lower()}-lossy-{kind}", memory(kind, 1), [f"COMPRESS={compress}", "MAX_Z_ERROR=0.5"] + tiled))
    # LERC with NaN and with alpha.
    for compress in ("LERC", "LERC_ZSTD"):
        mem = memory("float32", 1)
        a = mem.ReadAsArray()
        a[10:30, 20:50] = np.nan
        mem.WriteArray(a)
        add(write(folder, f"{compress.lower()}-nan", mem, [f"COMPRESS={compress}"] + tiled))
        for binary in (True, False):
            mem = memory("byte", 4)
            mem.GetRasterBand(4).SetColorInterpretation(gdal.GCI_AlphaBand)
            a = mem.GetRasterBand(4).ReadAsArray()
            mem.GetRasterBand(4).WriteArray((a > 100).astype("u1") * 255 if binary else a)
            add(write(folder, f"{compress.lower()}-alpha-{'binary' if binary else 'grey'}", mem, [f"COMPRESS={compress}", "ALPHA=YES"] + tiled))
    # Alpha, palettes, white is zero.
    for bands, alpha in itertools.product([2, 4], ["YES", "PREMULTIPLIED", "NON-PREMULTIPLIED"]):
        for kind in ("byte", "uint16"):
            mem = memory(kind, bands)
            mem.GetRasterBand(bands).SetColorInterpretation(gdal.GCI_AlphaBand)
            add(write(folder, f"alpha-{kind}-{bands}-{alpha.lower()}", mem, ["COMPRESS=DEFLATE", f"ALPHA={alpha}"]))
    for bits, kind in ((1, "byte"), (2, "byte"), (4, "byte"), (8, "byte"), (16, "uint16")):
        mem = memory(kind, 1, bits)
        table = gdal.ColorTable()
        for i in range(2 ** bits):
            table.SetColorEntry(i, (i * 37 % 256, 255 - i * 11 % 256, i * i % 256, 255))
        mem.GetRasterBand(1).SetColorTable(table)
        add(write(folder, f"palette-{bits}", mem, ["COMPRESS=LZW"] + ([f"NBITS={bits}"] if bits < 8 else [])))
    add(write(folder, "white-is-zero", memory("byte", 1), ["PHOTOMETRIC=MINISWHITE"]))
    add(write(folder, "cmyk", memory("byte", 4), ["PHOTOMETRIC=CMYK"]))
    add(write(folder, "lab", memory("byte", 3), ["PHOTOMETRIC=CIELAB"]))
    add(write(folder, "fax4", memory("byte", 1, 1), ["NBITS=1", "COMPRESS=CCITTFAX4"]))
    add(write(folder, "many-bands", memory("int16", 37), ["COMPRESS=DEFLATE", "INTERLEAVE=PIXEL"]))
    # Nodata, scale, sparse.
    for kind, nodata in (("byte", 0), ("int16", -32768), ("float32", -3.4028234663852886e38), ("float32", float("nan")), ("float64", -1e300), ("int32", -2147483648), ("uint16", 65535), ("float32", -9999.5), ("float32", float("-inf"))):
        mem = memory(kind, 1)
        mem.GetRasterBand(1).SetNoDataValue(nodata)
        a = mem.ReadAsArray()
        a[5:20, 30:] = nodata
        mem.WriteArray(a)
        add(write(folder, f"nodata-{kind}-{nodata}", mem, ["COMPRESS=DEFLATE"] + tiled))
        add(write(folder, f"sparse-{kind}-{nodata}", mem, ["COMPRESS=DEFLATE", "SPARSE_OK=TRUE"] + tiled))
    mem = memory("int16", 2)
    for b, (scale, offset) in enumerate(((0.1, -500), (2, 7))):
        mem.GetRasterBand(b + 1).SetScale(scale)
        mem.GetRasterBand(b + 1).SetOffset(offset)
    add(write(folder, "scale-offset", mem, ["COMPRESS=DEFLATE"]))
    for compress in ("NONE", "DEFLATE", "JPEG", "LERC"):
        mem = memory("byte", 3)
        path = os.path.join(folder, f"holes-{compress.lower()}.tif")
        ds = gdal.GetDriverByName("GTiff").Create(path, W, H, 3, gdal.GDT_Byte, ["SPARSE_OK=TRUE", f"COMPRESS={compress}"] + tiled)
        ds.WriteRaster(16, 0, 16, 32, b"\x64" * 16 * 32 * 3)
        ds = None
        add(path)
    # Overviews and masks, inside and beside.
    for outside, mask in itertools.product([False, True], [None, "inside", "beside"]):
        for kind, bands in (("byte", 3), ("float32", 1)):
            for compress in ("DEFLATE", "JPEG", "LERC") if kind == "byte" else ("DEFLATE", "LERC_ZSTD"):
                mem = memory(kind, bands)
                if mask:
                    mem.CreateMaskBand(gdal.GMF_PER_DATASET)
                    y, x = np.mgrid[0:H, 0:W]
                    mem.GetRasterBand(1).GetMaskBand().WriteArray((((x - 30) ** 2 + (y - 20) ** 2) > 150).astype("u1") * 255)
                name = f"overviews-{'beside' if outside else 'inside'}-mask-{mask}-{kind}-{compress.lower()}"
                path = write(folder, name, mem, [f"COMPRESS={compress}"] + tiled, GDAL_TIFF_INTERNAL_MASK="YES" if mask == "inside" else "NO")
                if not path:
                    continue
                gdal.SetConfigOption("GDAL_TIFF_INTERNAL_MASK", "YES" if mask == "inside" else "NO")
                ds = gdal.Open(path, gdal.GA_ReadOnly if outside else gdal.GA_Update)
                gdal.SetConfigOption("COMPRESS_OVERVIEW", compress)
                ds.BuildOverviews("AVERAGE", [2, 4])
                gdal.SetConfigOption("COMPRESS_OVERVIEW", None)
                ds = None
                gdal.SetConfigOption("GDAL_TIFF_INTERNAL_MASK", None)
                files.append(path)
    # COGs.
    for kind, bands, compress in (("float32", 1, "LERC"), ("byte", 3, "JPEG"), ("byte", 4, "WEBP"), ("int16", 1, "ZSTD"), ("float32", 1, "LERC_DEFLATE")):
        mem = memory(kind, bands)
        path = os.path.join(folder, f"cog-{kind}-{bands}-{compress.lower()}.tif")
        try:
            gdal.GetDriverByName("COG").CreateCopy(path, mem, options=[f"COMPRESS={compress}", "BLOCKSIZE=128", "OVERVIEW_COUNT=2"])
            files.append(path)
        except RuntimeError as error:
            print(f"# GDAL does not write {path}: {error}", file=sys.stderr)
    return files


class Reader:
    """The example, answering line by line."""

    def __init__(self, program, folder):
        self.out = os.path.join(folder, "samples.f32")
        self.process = subprocess.Popen([program], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)

    def read(self, path, level, kind, select, width, height):
        if os.path.exists(self.out):
            os.remove(self.out)
        self.process.stdin.write(f"{path}\t{level}\t{kind}\t{select}\t{self.out}\n")
        self.process.stdin.flush()
        status, _, text = self.process.stdout.readline().rstrip("\n").partition("\t")
        if status != "read":
            return None, text
        samples = np.fromfile(self.out, "<f4")
        if samples.size % (width * height):
            return None, f"WRONG SIZE {text}"
        return samples.reshape(-1, height, width), text


def expected_heights(full, band):
    """What GDAL holds, with scale and offset; NaN where it says that nothing is there."""
    values = band.ReadAsArray().astype("f8")
    if band.DataType == gdal.GDT_Byte and band.GetMetadataItem("PIXELTYPE", "IMAGE_STRUCTURE") == "SIGNEDBYTE":
        values = np.where(values > 127, values - 256, values)
    mask = band.GetMaskBand().ReadAsArray()
    values = values * (full.GetScale() or 1) + (full.GetOffset() or 0)
    with np.errstate(over="ignore"):
        values = values.astype("f4")
    values[mask == 0] = np.nan
    values[~np.isfinite(values)] = np.nan
    return values


def difference(found, expected, sparse, lossy):
    """Largest difference; infinity where holes differ."""
    holes, empty = np.isnan(found), np.isnan(expected)
    if lossy:
        # Alpha was blurred as everything else.
        holes = empty = holes | empty
    if sparse:
        # What a file leaves out is a hole here and zero there.
        empty = empty | (holes & (expected == 0))
    if (holes != empty).any():
        return np.inf
    d = np.abs(found.astype("f8") - expected.astype("f8"))[~holes]
    return d.max() if d.size else 0.0


def misplaced_on_purpose(dataset):
    """Whether GDAL hands on degrees of another unit as they are."""
    return dataset.GetSpatialRef() is None


def compare(reader, path):
    """Verdict, largest difference, remark."""
    try:
        dataset = gdal.Open(path)
    except RuntimeError as error:
        return "GDAL refuses", 0, str(error)
    lossy = (dataset.GetMetadataItem("COMPRESSION", "IMAGE_STRUCTURE") or "") in ("JPEG", "YCbCr JPEG", "WEBP")
    sparse = "holes" in path or "sparse" in path
    worst, text, levels = 0.0, "", 1 + dataset.GetRasterBand(1).GetOverviewCount()
    alpha = [b for b in range(1, dataset.RasterCount + 1) if dataset.GetRasterBand(b).GetColorInterpretation() == gdal.GCI_AlphaBand]
    for level in range(levels):
        for number in range(1, dataset.RasterCount + 1):
            full = dataset.GetRasterBand(number)
            band = full if level == 0 else full.GetOverview(level - 1)
            if number in alpha and level == 0:
                expected = band.ReadAsArray().astype("f4")
            else:
                expected = expected_heights(full, band)
            found, answer = reader.read(path, level, "height", number - 1, band.XSize, band.YSize)
            text = text if found is None and level > 0 else answer
            if found is None and level > 0 and answer.startswith("expected level"):
                # Overviews without the mask of the full image are made again.
                continue
            if found is None:
                return "refused", 0, answer
            worst = max(worst, difference(found[0], expected, sparse, lossy))
    first = dataset.GetRasterBand(1)
    table = first.GetColorTable()
    # Colours are the stored bytes; other types show their range, and alpha may be divided out.
    plain = first.DataType == gdal.GDT_Byte and not first.GetMetadata("IMAGE_STRUCTURE") and "premultiplied" not in path
    if table is not None or (plain and dataset.RasterCount - len(alpha) == 3):
        found, text = reader.read(path, 0, "colour", "-", dataset.RasterXSize, dataset.RasterYSize)
        if found is None:
            return "refused", 0, text
        planes = [first] * 3 if table is not None else [dataset.GetRasterBand(b) for b in (1, 2, 3)]
        for i, band in enumerate(planes):
            values = band.ReadAsArray()
            if table is not None:
                lookup = np.array([table.GetColorEntry(n)[i] for n in range(table.GetCount())])
                values = lookup[values]
            values = values.astype("f8")
            opaque = found[3] > 0
            d = np.abs(found[i] * 255 - values)[opaque]
            worst = max(worst, d.max() if d.size else 0)
    place = dataset.GetGeoTransform(can_return_null=True)
    if place and "[" in text and not misplaced_on_purpose(dataset):
        found = [float(v) for v in text[text.rindex("[") + 1:-1].split(",")]
        if not np.allclose(found, place, rtol=1e-9, atol=1e-12):
            return "WRONG", 0, f"place {found} instead of {place}"
    elif place and "[" not in text:
        return "WRONG", 0, f"no place instead of {place}: {text}"
    limit = 10 if lossy else 5e-4 if table is not None or first.DataType == gdal.GDT_Byte else 0
    return ("read" if worst <= limit else "WRONG"), worst, text


def main():
    program, folder, files = sys.argv[1], sys.argv[2], sys.argv[3:]
    os.makedirs(folder, exist_ok=True)
    made = make(folder) if not files else []
    reader = Reader(program, folder)
    counts = {}
    for path in made + files:
        verdict, worst, remark = compare(reader, path)
        counts[verdict] = counts.get(verdict, 0) + 1
        print(f"{os.path.basename(path)[:-4]}\t{verdict}\t{worst:.6g}\t{remark.replace(folder, '')}")
    print("# " + ", ".join(f"{n} {v}" for v, n in sorted(counts.items())))


main()
