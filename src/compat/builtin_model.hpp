// BuiltinModel: a model of one of Weir's engines in NNStreamer's structures, for programs that open
// and invoke it without a pipeline. The functions return 0 or a negative number of errno, with a
// log line.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "core/direct/direct_model.hpp"
#include "nnstreamer_plugin_api_filter.h"
#include "weir/abi.h"

namespace weir::compat {

class BuiltinModel {
 public:
  // Null when no model is set or it does not open.
  static std::unique_ptr<BuiltinModel> open(const weir_engine& engine,
                                            const GstTensorFilterProperties& prop);
  // The same with other files.
  std::unique_ptr<BuiltinModel> open_other(std::vector<std::string> paths) const;

  // Write the tensors of the model; the caller's struct may be uninitialised. Extents that the
  // model leaves open are 1 until the caller sets them. -ENOENT if they are unknown. `in` may be
  // null.
  int get_inputs(GstTensorsInfo* in);
  int get_outputs(GstTensorsInfo* out);
  // Sets the shapes of the inputs.
  int set_inputs(const GstTensorsInfo& in, GstTensorsInfo* out);
  // The same where the model file has other shapes, in any rank. -EPERM if the engine takes none.
  int resize_inputs(const GstTensorsInfo& in, GstTensorsInfo* out);
  // Copies the outputs into the caller's memory; allocates where it has none. 1: the model has no
  // output for this frame. `prop` may be null.
  int invoke(GstTensorFilterProperties* prop, const GstTensorMemory* input,
             GstTensorMemory* output);

  const std::vector<std::string>& paths() const noexcept { return options_.paths; }
  const infer::Model& model() const noexcept { return model_->model(); }

 private:
  BuiltinModel(const weir_engine& engine, infer::OpenOptions options,
               std::unique_ptr<direct::DirectModel> model)
      : engine_(&engine), options_(std::move(options)), model_(std::move(model)) {}
  static std::unique_ptr<BuiltinModel> open(const weir_engine& engine, infer::OpenOptions options);

  const weir_engine* engine_;
  infer::OpenOptions options_;
  std::unique_ptr<direct::DirectModel> model_;
};

}  // namespace weir::compat
