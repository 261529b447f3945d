"""Runs scikit-image's active_contour on the cases in a folder and prints, for each, how long the
call took and where the contour went: the peer of snake_bench.

  snake_peer.py FOLDER write       writes scikit-image's own example pictures into the folder
  snake_peer.py FOLDER run         a line per case: NAME ms row,column row,column ...

A case is NAME.case: the picture's file, the Gaussian's sigma, the options as Python, then the
starting points, row and column, a line each.
"""
import glob
import os
import sys
import time

import numpy as np
from skimage import data, io
from skimage.color import rgb2gray
from skimage.filters import gaussian
from skimage.segmentation import active_contour
from skimage.util import img_as_ubyte


def write(folder):
    io.imsave(os.path.join(folder, 'text.png'), data.text(), check_contrast=False)
    grey = img_as_ubyte(rgb2gray(data.astronaut()))
    io.imsave(os.path.join(folder, 'astronaut.png'), grey, check_contrast=False)


def run(folder):
    for path in sorted(glob.glob(os.path.join(folder, '*.case'))):
        with open(path) as file:
            picture, sigma, options, *points = file.read().splitlines()
        image = io.imread(os.path.join(folder, picture)).astype(float) / 255.0
        smooth = gaussian(image, float(sigma))
        start = np.array([[float(v) for v in point.split()] for point in points])
        options = eval(options)  # our own file
        begin = time.process_time()
        contour = active_contour(smooth, start, **options)
        ms = 1e3 * (time.process_time() - begin)
        name = os.path.splitext(os.path.basename(path))[0]
        print(name, ms, *['%.6f,%.6f' % tuple(p) for p in contour])


{'write': write, 'run': run}[sys.argv[2]](sys.argv[1])
