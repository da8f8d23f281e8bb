// PythonModel: an object of a script's class CustomFilter, and what it says of its tensors.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "module_host.hpp"
#include "numpy_api.hpp"

namespace weir::engine {

// Its functions are called under Locked, but for open, describe and the destructor.
class PythonModel {
 public:
  // MODULE_REFUSED when the script fails or is no filter; ENGINE_NOT_INSTALLED without Python.
  static Result<std::unique_ptr<PythonModel>> open(const weir_open& request);
  PythonModel(const PythonModel&) = delete;
  PythonModel& operator=(const PythonModel&) = delete;
  ~PythonModel();

  // A script with setInputDim has no tensors here: their number is the stream's.
  void describe(weir_model_info* info) const;

  const python::PythonApi& api() const noexcept { return api_; }
  const python::Numpy& numpy() const noexcept { return numpy_; }
  bool is_told() const noexcept { return is_told_; }
  const std::vector<weir_tensor_info>& outputs() const noexcept { return outputs_; }
  // Of setInputDim.
  Result<std::vector<weir_tensor_info>> tell(std::span<const weir_tensor_info> inputs);
  // script.invoke(arrays)
  Result<python::Object> invoke(python::Object arrays);
  // A tuple of dense arrays for these outputs; INVOKE_FAILED names what is wrong with `made`.
  Result<python::Object> checked(const python::Object& made,
                                 std::span<const weir_tensor_info> outputs) const;
  // Of what invoke returned: whether nothing else has the list, or the array in such a list with
  // its memory, apart from one reference and one buffer of ours; then it is made read-only.
  bool is_only_list(const python::Object& made) const;
  bool give_away(python::PyObject* array) const;
  void collect_garbage() const;

 private:
  using Infos = std::vector<weir_tensor_info>;
  PythonModel(const python::PythonApi& api, std::string path) : api_(api), path_(std::move(path)) {}
  Status load(std::string_view arguments);
  Status measure();
  Result<Infos> told_by(const char* method);
  Result<python::Object> call(const char* function, std::vector<python::Object> arguments,
                              Code code) const;
  long long count(const char* function, python::PyObject* object) const;
  python::Object tensor_of(const weir_tensor_info& info) const;
  Result<Infos> infos_of(const python::Object& tensors) const;
  void add_tensors(std::span<const weir_tensor_info> infos,
                   std::vector<python::Object>* arguments) const;

  const python::PythonApi& api_;
  const std::string path_;
  python::Numpy numpy_;
  python::PyObject* names_ = nullptr;  // of filter_names.hpp; live until the process ends
  python::Object script_, invoke_;
  bool is_told_ = false;
  long long list_references_ = 0, array_references_ = 0;  // of what nothing else has
  Infos inputs_, outputs_;
};

}  // namespace weir::engine
