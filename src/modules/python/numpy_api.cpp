// SPDX-License-Identifier: LGPL-2.1-or-later
#include "numpy_api.hpp"

namespace weir::python {
namespace {

constexpr char kFind[] = R"py(
try:
    from numpy._core import _multiarray_umath as _found
except ImportError:
    from numpy.core import _multiarray_umath as _found

def table():
    return _found._ARRAY_API

def version():
    import numpy
    return numpy.__version__
)py";

// Indices into the table, and NumPy's type numbers on a 64-bit machine.
constexpr size_t kAbiVersion = 0, kArrayType = 2, kDescrFromType = 45, kNewFromDescr = 94,
                 kSetBaseObject = 282;
constexpr int kTypeNumbers[WEIR_TYPE_END] = {5, 6, 3, 4, 1, 2, 12, 11, 7, 8, 23};
constexpr int kContiguous = 0x1 | 0x2, kAligned = 0x100;
constexpr unsigned kFirstAbi = 0x1000009, kSecondAbi = 0x2000000;

Error unknown_numpy(const std::string& offered) {
  return {.code = Code::ENGINE_NOT_INSTALLED,
          .what = "this NumPy has an unknown binary interface",
          .offered = offered,
          .needed = "NumPy 1.7 to 2",
          .fix = "apt-get install python3-numpy"};
}

}  // namespace

Result<Numpy> Numpy::open(const PythonApi& api) {
  const auto names = module_of_ours("weir_numpy_table", kFind);
  if (!names) return names.error();
  const auto capsule = call(*names, "table", {}, Code::ENGINE_NOT_INSTALLED);
  if (!capsule) return capsule.error();
  auto* table = static_cast<void**>(api.PyCapsule_GetPointer(capsule->get(), nullptr));
  if (!table) return take_exception(Code::ENGINE_NOT_INSTALLED);
  const unsigned abi = reinterpret_cast<unsigned (*)()>(table[kAbiVersion])();
  if (abi != kFirstAbi && abi != kSecondAbi) return unknown_numpy("version " + std::to_string(abi));
  Numpy numpy;
  numpy.array_type_ = static_cast<PyObject*>(table[kArrayType]);
  numpy.descr_from_type_ = reinterpret_cast<decltype(descr_from_type_)>(table[kDescrFromType]);
  numpy.new_from_descr_ = reinterpret_cast<decltype(new_from_descr_)>(table[kNewFromDescr]);
  numpy.set_base_ = reinterpret_cast<decltype(set_base_)>(table[kSetBaseObject]);
  return numpy;
}

Object Numpy::view(uint32_t type, const void* data, int64_t count, const Object& owner) const {
  const intptr_t shape[] = {static_cast<intptr_t>(count)};
  PyObject* descr = descr_from_type_(kTypeNumbers[type]);
  Object array =
      Object::adopt(new_from_descr_(array_type_, descr, 1, shape, nullptr, const_cast<void*>(data),
                                    kContiguous | kAligned, nullptr));
  if (!array) return array;
  if (set_base_(array.get(), Object::share(owner.get()).release()) != 0) return {};
  return array;
}

}  // namespace weir::python
