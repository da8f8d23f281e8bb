// PythonSession: runs a script on frames.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "frame_hold.hpp"
#include "python3/python_model.hpp"

namespace weir::engine {

// For the only script of the model. One thread at a time.
class PythonSession {
 public:
  static Result<std::unique_ptr<PythonSession>> create(PythonModel& model,
                                                       std::span<const weir_option> options);
  Status resolve(std::span<const weir_tensor_info> in, std::span<weir_tensor_info> out);
  // Inputs are read in place. Outputs are copied once into the given memory; without given memory,
  // an array that the script no longer refers to is handed over without a copy.
  // False: the script has no result for this frame.
  Result<bool> invoke(const weir_frame& in, weir_frame& out);

 private:
  explicit PythonSession(PythonModel& model);
  Result<bool> run(const weir_frame& in, weir_frame& out, const python::Object& owner);
  Result<python::Object> make_arrays(const weir_frame& in, const python::Object& owner) const;
  Result<bool> write(const python::Object& made, weir_frame& out) const;
  Result<bool> write_sized(const python::Object& made, weir_frame& out) const;
  // `ours`: only we refer to the list that holds the array.
  Result<bool> write(const python::Object& array, bool ours, size_t index,
                     weir_tensor* tensor) const;
  bool is_array(const python::Object& object) const;
  bool hand_over(const python::Object& array, void* data, weir_tensor* tensor) const;

  PythonModel& model_;
  const python::PythonApi& api_;
  std::vector<weir_tensor_info> outputs_;
  std::optional<Error> kept_;  // set once the script keeps an array of its input after invoke
};

}  // namespace weir::engine
