// PythonSession: frames through a script.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "frame_hold.hpp"
#include "python3/python_model.hpp"

namespace weir::engine {

// Of the model's only script; one thread at a time uses it.
class PythonSession {
 public:
  static Result<std::unique_ptr<PythonSession>> create(PythonModel& model,
                                                       std::span<const weir_option> options);
  Status resolve(std::span<const weir_tensor_info> in, std::span<weir_tensor_info> out);
  // Inputs are read where they are. Outputs are copied once into the memory that is given; where
  // none is, an array that is the script's no longer is handed over as it is.
  Status invoke(const weir_frame& in, weir_frame& out);

 private:
  explicit PythonSession(PythonModel& model);
  Status run(const weir_frame& in, weir_frame& out, const python::Object& owner);
  Result<python::Object> arrays_of(const weir_frame& in, const python::Object& owner) const;
  Status write(const python::Object& made, weir_frame& out) const;
  // `ours`: nothing else has the list that the array came in.
  Result<bool> write(const python::Object& array, bool ours, size_t index,
                     weir_tensor* tensor) const;
  bool is_array(const python::Object& object) const;
  bool hand_over(const python::Object& array, void* data, weir_tensor* tensor) const;

  PythonModel& model_;
  const python::PythonApi& api_;
  std::vector<weir_tensor_info> outputs_;
  std::optional<Error> kept_;  // set once the script kept what it must not keep
};

}  // namespace weir::engine
