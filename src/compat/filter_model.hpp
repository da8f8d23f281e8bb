// FilterModel: an OpenFilter as a model of a Weir engine.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>
#include <span>
#include <vector>

#include "compat/open_filter.hpp"
#include "core/infer/model/declared_options.hpp"
#include "weir/engine.hpp"

namespace weir::compat {

class FilterModel {
 public:
  static constexpr const char* kOptions = infer::kAllDeclared;
  explicit FilterModel(std::shared_ptr<OpenFilter> filter);

  // Required by weir::engine_table().
  std::span<const weir_tensor_info> inputs() const { return inputs_.infos; }
  std::span<const weir_tensor_info> outputs() const { return outputs_.infos; }
  void describe(weir_model_info& info) const;
  void resolve(std::span<const weir_tensor_info> in, std::span<weir_tensor_info> out);
  bool invoke(const weir_frame& in, weir_frame& out);
  void submit(const weir_frame& in, Request& request);
  void control(int op, const weir_option* option);

 private:
  void follow(const weir_frame& in);
  void describe_outputs(std::span<const weir_tensor_info> in);
  void point_to(const weir_frame& in);
  int run();
  bool invoke_in_place(weir_frame& out);
  bool invoke_allocating(weir_frame& out);
  void fill_given(weir_frame& out);
  void fill_dynamic(weir_frame& out);
  void drop_outputs() noexcept;

  std::shared_ptr<OpenFilter> filter_;
  bool dynamic_, allocates_;
  Described inputs_, outputs_;             // of the model; none: it follows the stream
  std::vector<weir_tensor_info> stream_;   // the inputs last passed to the filter
  Described resolved_outputs_;             // the outputs for them
  std::vector<GstTensorMemory> in_, out_;  // of the current frame
};

// For weir::engine_table(): models of filters opened by `open`, which throws Failure.
template <std::shared_ptr<OpenFilter> (*open)(const OpenRequest&)>
class Opened : public FilterModel {
 public:
  explicit Opened(const OpenRequest& request) : FilterModel(open(request)) {}
};

}  // namespace weir::compat
