# SPDX-License-Identifier: LGPL-2.1-or-later
"""A detector that looks at no picture: frame after frame, what a file det.txt of MOTChallenge has for it.

tensor_filter framework=python3 model=found_boxes.py custom=FOLDER/det/det.txt

The output has rows of x1, y1, x2, y2, score, as many as the frame with the most boxes; the others are zeros.
"""

import numpy
from weir import TensorShape


class CustomFilter:
    def __init__(self, path):
        lines = numpy.loadtxt(path, delimiter=",", ndmin=2)
        self.rows = {}
        for frame, _, x, y, width, height, score in lines[:, :7]:
            self.rows.setdefault(int(frame), []).append([x - 1, y - 1, x - 1 + width, y - 1 + height, score])
        self.most = max(map(len, self.rows.values()), default=1)
        self.frame = 0

    def setInputDim(self, input_dims):
        return [TensorShape([5, self.most], numpy.float32)]

    def invoke(self, input_array):
        self.frame += 1
        out = numpy.zeros((self.most, 5), numpy.float32)
        rows = self.rows.get(self.frame, [])
        out[:len(rows)] = numpy.array(rows).reshape(-1, 5)
        return [out]
