#!/usr/bin/python3
"""Where the expected values of test_runtime_metrics.c come from: other implementations of the metrics.

RMSE and PSNR by NumPy, SSIM by scikit-image's structural_similarity, FLIP by the formulas of the paper (Andersson et al.
2020) in double precision with two-dimensional filters, which metrics_flip() does with separable ones. Debian packages:
python3-numpy python3-skimage. The pictures are those that the test writes:

    mkdir pairs && DAFT_WRITE_PAIRS=pairs build/release/tests/test_runtime_metrics
    python3 tests/data/accuracy/metrics_oracle.py pairs
"""
import sys
import numpy as np

WIDTH, HEIGHT = 96, 64
PPD = 0.7 * 3840 / 0.7 * np.pi / 180
TO_XYZ = np.array([[10135552, 8788810, 4435075], [2613072 * 2, 8788810 * 2, 887015 * 2],
                   [1425312 / 3, 8788810 / 3, 70074185 / 3]]) / 24577794
WHITE = TO_XYZ @ np.ones(3)


def load(path):
    return np.fromfile(path, np.uint8).reshape(HEIGHT, WIDTH, 4)[..., :3]


def linear(rgb):
    e = rgb / 255
    return np.where(e <= 0.04045, e / 12.92, ((e + 0.055) / 1.055) ** 2.4)


def convolve(image, kernel):
    r = kernel.shape[0] // 2
    wide = np.pad(image, r, mode="edge")
    out = np.zeros_like(image)
    for y in range(2 * r + 1):
        for x in range(2 * r + 1):
            out += kernel[y, x] * wide[y:y + HEIGHT, x:x + WIDTH]
    return out


def grid(radius):
    return np.meshgrid(np.arange(-radius, radius + 1), np.arange(-radius, radius + 1))


def blur(terms):
    x, y = grid(int(np.ceil(3 * np.sqrt(0.04 / (2 * np.pi ** 2)) * PPD)))
    square = (x ** 2 + y ** 2) / PPD ** 2
    kernel = sum(a * np.sqrt(np.pi / b) * np.exp(-np.pi ** 2 * square / b) for a, b in terms)
    return kernel / kernel.sum()


def opponent(rgb):
    x, y, z = np.moveaxis(linear(rgb) @ TO_XYZ.T / WHITE, -1, 0)
    return 116 * y - 16, 500 * (x - y), 200 * (y - z)


def hunt(rgb):
    t = rgb @ TO_XYZ.T / WHITE
    f = np.where(t > (6 / 29) ** 3, np.cbrt(t), t / (3 * (6 / 29) ** 2) + 4 / 29)
    lightness = 116 * f[..., 1] - 16
    return np.stack([lightness, 0.01 * lightness * 500 * (f[..., 0] - f[..., 1]),
                     0.01 * lightness * 200 * (f[..., 1] - f[..., 2])], -1)


def hyab(a, b):
    return np.abs(a[..., 0] - b[..., 0]) + np.linalg.norm((a - b)[..., 1:], axis=-1)


def perceived(channels):
    terms = [(1, 0.0047)], [(1, 0.0053)], [(34.1, 0.04), (13.5, 0.025)]
    a, rg, by = (convolve(c, blur(t)) for c, t in zip(channels, terms))
    y = (a + 16) / 116
    xyz = np.stack([y + rg / 500, y, y - by / 200], -1) * WHITE
    return hunt(np.clip(xyz @ np.linalg.inv(TO_XYZ).T, 0, 1))


def feature(luma, point):
    deviation = 0.5 * 0.082 * PPD
    x, y = grid(int(np.ceil(3 * deviation)))
    bell = np.exp(-(x ** 2 + y ** 2) / (2 * deviation ** 2))
    kernel = (x ** 2 / deviation ** 2 - 1) * bell if point else -x * bell
    kernel = np.where(kernel > 0, kernel / kernel[kernel > 0].sum(), kernel / -kernel[kernel < 0].sum())
    # correlation or convolution: only the sign of the response differs
    return np.hypot(convolve(luma, kernel), convolve(luma, kernel.T))


def flip(picture, reference):
    channels = opponent(picture), opponent(reference)
    power = hyab(*(perceived(c) for c in channels)) ** 0.7
    largest = hyab(hunt(np.array([0., 1, 0])), hunt(np.array([0., 0, 1]))) ** 0.7
    knee = 0.4 * largest
    colour = np.where(power < knee, 0.95 * power / knee, 0.95 + 0.05 * (power - knee) / (largest - knee))
    lumas = [(c[0] + 16) / 116 for c in channels]
    change = np.maximum(*(np.abs(feature(lumas[0], p) - feature(lumas[1], p)) for p in (False, True)))
    return colour ** (1 - np.sqrt(change / np.sqrt(2)))


def ssim(picture, reference):
    from skimage.metrics import structural_similarity
    luma = [p @ np.array([0.299, 0.587, 0.114]) / 255 for p in (picture, reference)]
    return structural_similarity(*luma, gaussian_weights=True, sigma=1.5, use_sample_covariance=False, data_range=1)


for name in "waves-shift", "waves-dark", "steps-shift", "steps-noise":
    p, r = (load(f"{sys.argv[1]}/{name}-{kind}.rgba") for kind in ("picture", "reference"))
    rmse = np.sqrt(np.mean((linear(p) - linear(r)) ** 2))
    tiles = flip(p, r).reshape(HEIGHT // 32, 32, WIDTH // 32, 32).mean((1, 3))
    print(f'    {{"{name}", {rmse:.7f}, {-20 * np.log10(rmse):.5f}, {ssim(p, r):.6f}, {tiles.mean():.6f}, {tiles.max():.6f}}},')
