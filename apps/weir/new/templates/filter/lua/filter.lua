-- The filter my-filter: y = 255 - x, for four bytes. Dimensions are innermost first.
inputTensorsInfo = {num = 1, dim = {{4, 1, 1, 1}}, type = {'uint8'}}
outputTensorsInfo = {num = 1, dim = {{4, 1, 1, 1}}, type = {'uint8'}}

function nnstreamer_invoke()
  local x, y = input_tensor(1), output_tensor(1)
  for i = 1, #x do y[i] = 255 - x[i] end
end
