-- Runs before a script, in the script's state: creates the tensors that scripts see and reads the
-- script's tables. Scripts can reach the functions made here but not their upvalues: neither `ffi`
-- nor an address. Library functions are kept in locals because scripts may replace them.
-- SPDX-License-Identifier: LGPL-2.1-or-later
local ffi, globals, half_to_float, float_to_half, unshare, sandbox = ...
local error, ipairs, load, loadfile, pcall, rawget = error, ipairs, load, loadfile, pcall, rawget
local select, tonumber, tostring, type = select, tonumber, tostring, type
local concat, floor, format, lower = table.concat, math.floor, string.format, string.lower
local cast, metatype, typeof = ffi.cast, ffi.metatype, ffi.typeof

-- In the order of weir_type.
local names = {'int32', 'uint32', 'int16', 'uint16', 'int8', 'uint8', 'float64', 'float32', 'int64',
               'uint64', 'float16'}
local c_types = {'int32_t', 'uint32_t', 'int16_t', 'uint16_t', 'int8_t', 'uint8_t', 'double', 'float',
                 'int64_t', 'uint64_t', 'uint16_t'}
local min_tensors, max_tensors, max_dimensions, max_elements = 1, 256, 16, 2147483647
local int64 = typeof('int64_t')
half_to_float = cast('float (*)(uint16_t)', half_to_float)
float_to_half = cast('uint16_t (*)(float)', float_to_half)
unshare = cast('int (*)(void *)', unshare)

-- ---- What scripts may call --------------------------------------------------------------------

-- Without `newproxy`, no script code runs outside a call, when tensors have no memory.
globals.newproxy = nil
string.dump = nil

-- Source text only: byte code can do anything, and fails in other versions of LuaJIT.
function globals.load(chunk, name, _, ...)
  if select('#', ...) > 0 then return load(chunk, name, 't', (...)) end
  return load(chunk, name, 't')
end
function globals.loadstring(text, name)
  return load(text, name or text, 't')
end
if sandbox then
  globals.dofile, globals.loadfile = nil, nil
else
  function globals.loadfile(file, _, ...)
    if select('#', ...) > 0 then return loadfile(file, 't', (...)) end
    return loadfile(file, 't')
  end
  function globals.dofile(file)
    local chunk, why = loadfile(file, 't')
    if not chunk then error(why, 0) end
    return chunk()
  end
end

-- ---- Tensors ----------------------------------------------------------------------------------

local described  -- {input = {...}, output = {...}}: a text such as 'uint8 3:224:224' per tensor

-- Level 3: the line of the script that indexed the tensor.
local function refuse_key(title, count, text, key)
  if type(key) ~= 'number' then
    error(format('%s[%s]: tensors have elements only, counted from 1', title, tostring(key)), 3)
  end
  error(format('%s[%s] is out of range: it has %d elements, counted from 1 (%s)', title, tostring(key),
               count, text), 3)
end

-- Accepts text of a number and 64-bit integers; any other value is an error.
local function to_number(title, key, value)
  local number = tonumber(value)
  if number and type(value) == 'cdata' then return value end
  if not number then
    error(format('%s[%s] = %s: a number is needed', title, tostring(key), tostring(value)), 3)
  end
  return number
end

-- A TensorSlot of the host. Each access checks its index against the host's number of elements.
local function slot_type(c_type)
  return typeof('$ *', typeof('struct {' .. c_type .. ' *data; int32_t shared; uint32_t type; double elements; }'))
end

-- `shared`: others may read the memory, so the first write copies it.
local function make_tensor(title, text, address, shared)
  local slot = cast(slot_type('void'), address)
  local kind, count = slot.type + 1, slot.elements
  local element = names[kind]
  slot = cast(slot_type(c_types[kind]), address)
  local meta = {}

  if element == 'float16' then
    function meta.__index(_, key)
      if type(key) ~= 'number' or key < 1 or key > count or key ~= floor(key) then
        refuse_key(title, count, text, key)
      end
      return half_to_float(slot.data[key - 1])
    end
  elseif element == 'int64' or element == 'uint64' then
    function meta.__index(_, key)
      if type(key) ~= 'number' or key < 1 or key > count or key ~= floor(key) then
        refuse_key(title, count, text, key)
      end
      return tonumber(slot.data[key - 1])
    end
  else
    function meta.__index(_, key)
      if type(key) ~= 'number' or key < 1 or key > count or key ~= floor(key) then
        refuse_key(title, count, text, key)
      end
      return slot.data[key - 1]
    end
  end

  local function own_memory()
    if unshare(slot) == 0 then error(title .. ': memory ran out for a copy to write into', 3) end
  end
  if element == 'float16' then
    function meta.__newindex(_, key, value)
      if type(key) ~= 'number' or key < 1 or key > count or key ~= floor(key) then
        refuse_key(title, count, text, key)
      end
      if type(value) ~= 'number' then value = to_number(title, key, value) end
      if shared and slot.shared ~= 0 then own_memory() end
      slot.data[key - 1] = float_to_half(tonumber(value))
    end
  elseif element == 'uint64' then
    function meta.__newindex(_, key, value)
      if type(key) ~= 'number' or key < 1 or key > count or key ~= floor(key) then
        refuse_key(title, count, text, key)
      end
      if type(value) ~= 'number' then value = to_number(title, key, value) end
      if shared and slot.shared ~= 0 then own_memory() end
      if value < 2^63 then value = cast(int64, value) end
      slot.data[key - 1] = value
    end
  elseif element == 'float32' or element == 'float64' or element == 'int64' then
    function meta.__newindex(_, key, value)
      if type(key) ~= 'number' or key < 1 or key > count or key ~= floor(key) then
        refuse_key(title, count, text, key)
      end
      if type(value) ~= 'number' then value = to_number(title, key, value) end
      if shared and slot.shared ~= 0 then own_memory() end
      slot.data[key - 1] = value
    end
  else  -- via int64, so that interpreted and compiled code agree
    function meta.__newindex(_, key, value)
      if type(key) ~= 'number' or key < 1 or key > count or key ~= floor(key) then
        refuse_key(title, count, text, key)
      end
      if type(value) ~= 'number' then value = to_number(title, key, value) end
      if shared and slot.shared ~= 0 then own_memory() end
      slot.data[key - 1] = cast(int64, value)
    end
  end
  function meta.__len() return count end
  function meta.__tostring() return title .. ': ' .. text end
  return metatype(typeof('struct { }'), meta)()
end

local tensors = {input = {}, output = {}}
for _, role in ipairs({'input', 'output'}) do
  local list, title = tensors[role], role .. '_tensor'
  globals[title] = function(number)
    local tensor = list[number]
    if tensor then return tensor end
    if not described then
      error(title .. '(): the tensors are known when the script has run: call it in nnstreamer_invoke()', 2)
    end
    error(format('%s(%s): the script has %d %ss, counted from 1', title, tostring(number), #list, role), 2)
  end
end

-- `first`: the first of `count` slots, which the host fills for each frame.
local function bind_role(role, first, count, slot_bytes)
  for i = 1, count do
    local address = cast('char *', first) + (i - 1) * slot_bytes
    tensors[role][i] = make_tensor(format('%s_tensor(%d)', role, i), described[role][i], address, role == 'input')
  end
end

local function bind(inputs, input_count, outputs, output_count, slot_bytes)
  bind_role('input', inputs, input_count, slot_bytes)
  bind_role('output', outputs, output_count, slot_bytes)
end

-- ---- The script's tables ----------------------------------------------------------------------

local function show(value)
  if value == nil then return 'nothing' end
  if type(value) == 'string' then return format('%q', value) end
  if type(value) == 'number' or type(value) == 'boolean' then return tostring(value) end
  return 'a ' .. type(value)
end

local function fault(what, offered, needed)
  error({what = what, offered = offered, needed = needed}, 0)
end

local function whole(value, least, most)
  return type(value) == 'number' and value >= least and value <= most and value == floor(value)
end

-- A metamethod of the script may return another value each time, so each one is read once.
local function copy(list, count)
  local out = {}
  for i = 1, count do out[i] = list[i] end
  return out
end

-- {3, 224, 224} -> {224, 224, 3}: the host orders dimensions outermost first.
local function read_dimensions(field, given)
  if type(given) ~= 'table' then
    fault(field .. ' is not a list', show(given), 'a list of dimensions, innermost first: {3, 224, 224, 1}')
  end
  local rank = #given
  local list = copy(given, rank)
  while rank > 1 and list[rank] == 0 do rank = rank - 1 end
  if rank == 0 or rank > max_dimensions then
    fault(field .. ' has a number of dimensions that no tensor has', tostring(rank), '1 to 16')
  end
  local out, elements = {}, 1
  for i = rank, 1, -1 do
    if not whole(list[i], 1, max_elements) then
      fault(format('%s[%d] is not a dimension', field, i), show(list[i]), 'an integer of at least 1')
    end
    elements = elements * list[i]
    out[#out + 1] = list[i]
  end
  if elements > max_elements then
    fault(field .. ' is too large for a script', format('%.0f elements', elements), 'at most 2147483647')
  end
  return out
end

local function read_type(field, name)
  for i, known in ipairs(names) do
    if type(name) == 'string' and lower(name) == known then return i end
  end
  fault(field .. ' is not an element type', show(name), concat(names, ', '))
end

local function read_tensors(name)
  local info = rawget(globals, name)
  if type(info) ~= 'table' then
    fault('the script has no table ' .. name, show(info),
          name .. " = {num = 1, dim = {{3, 224, 224, 1}}, type = {'uint8'}}")
  end
  local num = info.num
  if not whole(num, min_tensors, max_tensors) then
    fault(name .. '.num is not a number of tensors', show(num), 'an integer from 1 to 256')
  end
  local lists = {}
  for _, field in ipairs({'dim', 'type'}) do
    local list = info[field]
    if type(list) ~= 'table' then
      fault(name .. '.' .. field .. ' is not a list', show(list),
            'a list with one entry for each of the ' .. num .. ' tensors')
    elseif #list ~= num then
      fault(format('%s.%s and %s.num have different lengths', name, field, name),
            format('%d in the list', #list), tostring(num))
    end
    lists[field] = copy(list, num)
  end
  local out = {}
  for i = 1, num do
    local dimensions = read_dimensions(format('%s.dim[%d]', name, i), lists.dim[i])
    local kind = read_type(format('%s.type[%d]', name, i), lists.type[i])
    local reversed = {}
    for d = #dimensions, 1, -1 do reversed[#reversed + 1] = dimensions[d] end
    out[i] = {type = kind, dimensions = dimensions, text = names[kind] .. ' ' .. concat(reversed, ':')}
  end
  return out
end

-- Returns a flat list for the host: the number of inputs, then each one's type (a weir_type), rank
-- and dimensions; the same for outputs. On failure: false, what is wrong, what came, what is
-- needed.
local function describe()
  local good, result = pcall(function()
    local read = {input = read_tensors('inputTensorsInfo'), output = read_tensors('outputTensorsInfo')}
    local invoke = rawget(globals, 'nnstreamer_invoke')
    if type(invoke) ~= 'function' then
      fault('the script has no function nnstreamer_invoke', show(invoke), 'function nnstreamer_invoke() ... end')
    end
    local flat, texts = {}, {input = {}, output = {}}
    for _, role in ipairs({'input', 'output'}) do
      flat[#flat + 1] = #read[role]
      for i, tensor in ipairs(read[role]) do
        texts[role][i] = tensor.text
        flat[#flat + 1] = tensor.type - 1
        flat[#flat + 1] = #tensor.dimensions
        for _, extent in ipairs(tensor.dimensions) do flat[#flat + 1] = extent end
      end
    end
    described = texts
    return flat
  end)
  if good then return result end
  if type(result) == 'table' and result.what then return false, result.what, result.offered, result.needed end
  return false, 'the tables of the script cannot be read', tostring(result), 'plain tables'
end

local function invoke()
  local call = rawget(globals, 'nnstreamer_invoke')
  if type(call) ~= 'function' then error('nnstreamer_invoke is no longer a function', 0) end
  local result = call()  -- no tail call: LuaJIT would not compile it
  return result
end

return describe, bind, invoke
