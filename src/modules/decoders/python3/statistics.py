# SPDX-License-Identifier: LGPL-2.1-or-later
"""Example script for tensor_decoder: a line of text with the smallest, mean and largest element of each tensor."""


class CustomDecoder:
    def getOutCaps(self):
        return b"text/x-raw, format=(string)utf8"

    def decode(self, raw_data, in_info, rate_n, rate_d):
        lines = (f"{info.getType()} {array.min()} {array.mean():.2f} {array.max()}\n"
                 for array, info in zip(raw_data, in_info))
        return "".join(lines).encode()
