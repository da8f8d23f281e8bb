// PythonModel: an instance of a script's class CustomFilter, and the tensors that it declares.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "numpy_api.hpp"
#include "weir/engine_tools.hpp"

namespace weir::engine {

// Call its functions under Locked, except open, describe and the destructor.
class PythonModel {
 public:
  // MODULE_REFUSED when the script fails or is not a filter; ENGINE_NOT_INSTALLED without Python.
  static Result<std::unique_ptr<PythonModel>> open(const weir_open& request);
  PythonModel(const PythonModel&) = delete;
  PythonModel& operator=(const PythonModel&) = delete;
  ~PythonModel();

  // For a script with setInputDim there are no tensors yet: the stream determines them.
  void describe(weir_model_info* info) const;

  const python::PythonApi& api() const noexcept { return api_; }
  const python::Numpy& numpy() const noexcept { return numpy_; }
  bool takes_input_shapes() const noexcept { return takes_input_shapes_; }
  const std::vector<weir_tensor_info>& outputs() const noexcept { return outputs_; }
  // Calls setInputDim.
  Result<std::vector<weir_tensor_info>> set_inputs(std::span<const weir_tensor_info> inputs);
  // Calls script.invoke(arrays).
  Result<python::Object> invoke(python::Object arrays);
  // Whether each invoke decides the sizes of its outputs (invoke-dynamic).
  bool decides_sizes() const noexcept { return decides_sizes_; }
  // Returns a tuple of dense arrays for these outputs, empty if the script has no result;
  // INVOKE_FAILED describes the error in `made`.
  Result<python::Object> checked(const python::Object& made,
                                 std::span<const weir_tensor_info> outputs) const;
  // The same with sizes that the arrays decide.
  struct Sized {
    std::vector<weir_tensor_info> infos;  // empty: no result
    python::Object arrays;
  };
  Result<Sized> checked_sizes(const python::Object& made,
                              std::span<const weir_tensor_info> outputs) const;
  // is_only_list: whether only we refer to the list that invoke returned. give_away: whether only
  // one reference and one buffer of ours refer to an array of such a list and its memory; then the
  // array becomes read-only.
  bool is_only_list(const python::Object& made) const;
  bool give_away(python::PyObject* array) const;
  void collect_garbage() const;

 private:
  using Infos = std::vector<weir_tensor_info>;
  PythonModel(const python::PythonApi& api, std::string path) : api_(api), path_(std::move(path)) {}
  Status load(std::string_view arguments);
  Status measure();
  Result<Infos> declared_by(const char* method);
  Result<python::Object> call(const char* function, std::vector<python::Object> arguments,
                              Code code) const;
  long long count(const char* function, python::PyObject* object) const;
  python::Object make_tensor(const weir_tensor_info& info) const;
  Result<Infos> to_infos(const python::Object& tensors) const;
  void open_rows(Infos* outputs) const;
  void add_tensors(std::span<const weir_tensor_info> infos,
                   std::vector<python::Object>* arguments) const;

  const python::PythonApi& api_;
  const std::string path_;
  python::Numpy numpy_;
  python::PyObject* names_ = nullptr;  // the module of kFilterNames; exists until the process exits
  python::Object script_, invoke_;
  bool takes_input_shapes_ = false, decides_sizes_ = false;
  long long list_references_ = 0,
            array_references_ = 0;  // reference counts of an unshared list and array
  Infos inputs_, outputs_;
};

}  // namespace weir::engine
