# SPDX-License-Identifier: LGPL-2.1-or-later
"""Example filter: passes frames of any kind unchanged."""


class CustomFilter:
    def setInputDim(self, input_dims):
        return input_dims

    def invoke(self, input_array):
        return input_array
