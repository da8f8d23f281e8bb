# SPDX-License-Identifier: LGPL-2.1-or-later
"""An example of a filter: frames of any kind pass as they are."""


class CustomFilter:
    def setInputDim(self, input_dims):
        return input_dims

    def invoke(self, input_array):
        return input_array
