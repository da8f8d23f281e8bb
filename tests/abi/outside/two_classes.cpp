// A third-party engine of two classes, a model and its sessions, that doubles float32 values.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <weir/engine_table.hpp>

#include <cstring>

namespace {

using weir::Result;
using weir::Status;

struct Doubled {
  static constexpr const char *kName = "outside-two-classes", *kAliases = "",
                              *kExtensions = "doubled", *kOptions = "[]",
                              *kLibrary = "the doubling library";

  struct Model {
    static Result<std::unique_ptr<Model>> open(const weir_open& request) {
      if (request.n_models != 1)
        return weir::Error{.code = weir::Code::FILE_NOT_FOUND,
                           .what = "the engine needs one file",
                           .needed = "model=FILE.doubled"};
      return std::make_unique<Model>();
    }
    void describe(weir_model_info* info) const {
      info->inputs = info->outputs = &tensor;
      info->n_inputs = info->n_outputs = 1;
      info->max_sessions = 4;
    }
    weir_tensor_info tensor = [] {
      weir_tensor_info out{};
      out.type = WEIR_FLOAT32;
      out.rank = 1;
      out.shape[0] = 4;
      out.batch_axis = WEIR_NO_BATCH_AXIS;
      return out;
    }();
  };

  struct Session {
    static Result<std::unique_ptr<Session>> create(Model&, std::span<const weir_option>) {
      return std::make_unique<Session>();
    }
    Status resolve(std::span<const weir_tensor_info> in, std::span<weir_tensor_info> out) {
      out[0] = in[0];
      return weir::ok();
    }
    Status invoke(const weir_frame& in, weir_frame& out) {
      const auto* from = static_cast<const float*>(in.tensors[0].data);
      auto* to = static_cast<float*>(out.tensors[0].data);
      for (size_t i = 0; i < in.tensors[0].bytes / sizeof(float); ++i) to[i] = 2 * from[i];
      return weir::ok();
    }
  };

  static int probe(const std::string& path, std::span<const unsigned char>) {
    return path.ends_with(".doubled") ? 100 : 0;
  }
  static Result<weir::engine::LibraryFacts> library() {
    return weir::engine::LibraryFacts{"/nowhere/libdouble.so", "1"};
  }
};

}  // namespace

WEIR_ENGINE_MODULE(Doubled)
