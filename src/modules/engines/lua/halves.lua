-- Half of each pixel's value, as float32.
-- SPDX-License-Identifier: LGPL-2.1-or-later
inputTensorsInfo = {num = 1, dim = {{3, 8, 8, 1}}, type = {'uint8'}}
outputTensorsInfo = {num = 1, dim = {{3, 8, 8, 1}}, type = {'float32'}}

function nnstreamer_invoke()
  local input, output = input_tensor(1), output_tensor(1)
  for i = 1, #input do output[i] = input[i] / 2 end
end
