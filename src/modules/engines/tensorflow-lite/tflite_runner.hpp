// TfliteRunner: runs a TensorFlow Lite model on frames.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>
#include <span>
#include <vector>

#include "tensorflow-lite/tflite_model.hpp"

namespace weir::engine {

// Owns an interpreter; one thread at a time.
class TfliteRunner {
 public:
  static Result<std::unique_ptr<TfliteRunner>> create(const TfliteModel& model,
                                                      std::span<const weir_option> options);

  // Resizes the inputs. Output sizes that the graph computes are found by a run on zeros, and stay
  // open if they depend on values.
  Status resolve(std::span<const weir_tensor_info> in, std::span<weir_tensor_info> out);
  // Copies inputs and outputs, because this library keeps tensors in its own memory. An output
  // without data gets memory of the host.
  Status invoke(const weir_frame& in, weir_frame& out);
  Status warm();
  Status reset_state();

 private:
  TfliteRunner(const TfliteModel& model, const TfliteApi& api,
               std::unique_ptr<TfliteInterpreter> interpreter);
  Status check(std::span<const weir_tensor_info> in) const;
  bool shaped_as(size_t index, const weir_tensor_info& info) const;
  Status reshape(std::span<const weir_tensor_info> in);
  Status fit(std::span<const weir_tensor> inputs);
  bool has_open_output() const;
  void find_output_shapes();
  Status copy_in(const weir_tensor& tensor, size_t index);
  Status copy_out(size_t index, weir_tensor* tensor);
  Status dry_run();

  const TfliteModel& model_;
  const TfliteApi& api_;
  std::unique_ptr<TfliteInterpreter> interpreter_;
  bool dry_ran_ = false;  // the sizes of computed outputs are known for the current shapes
  std::vector<uint8_t> bools_;
};

}  // namespace weir::engine
