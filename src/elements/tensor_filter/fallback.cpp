// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_filter/fallback.hpp"

#include <algorithm>
#include <chrono>

#include "core/filter/model_description.hpp"
#include "core/infer/model/warm_up.hpp"
#include "elements/tensor_filter/model_config.hpp"
#include "gstcpp/element/log.hpp"

namespace weir {
namespace {

using Shapes = Fallback::Shapes;

Status check_combination(const FilterSettings& s) {
  const auto other = [&](const std::string& what) {
    return Error{.code = Code::OPTION_VALUE,
                 .what = "these properties cannot be combined",
                 .offered = what + " with fallback=" + s.fallback,
                 .needed = "one of them",
                 .fix = "tensor_filter batch-size=1 invoke-async=false fallback=" + s.fallback};
  };
  if (s.batch_size > 1) return other("batch-size=" + std::to_string(s.batch_size));
  if (s.invoke_async) return other("invoke-async=true");
  return ok();
}

// Whether the tensors may turn out to be equal; -1 and an unknown type may become anything.
bool can_be_equal(const ModelTensor& a, const ModelTensor& b) {
  const bool types = a.type == b.type || a.type == ElementType::End || b.type == ElementType::End;
  if (!types) return false;
  if (!a.rank_known || !b.rank_known) return true;
  return std::equal(a.shape.begin(), a.shape.end(), b.shape.begin(), b.shape.end(),
                    [](int64_t x, int64_t y) { return x == y || x < 0 || y < 0; });
}

// "input 1", or "number of inputs"; "" for tensors that may be equal.
std::string difference(const Shapes& a, const Shapes& b, const std::string& role) {
  if (a.empty() || b.empty()) return "";  // known with the stream
  if (a.size() != b.size()) return "number of " + role + "s";
  for (size_t i = 0; i < a.size(); ++i)
    if (!can_be_equal(a[i], b[i])) return role + " " + std::to_string(i);
  return "";
}

std::string to_string(const Shapes& inputs, const Shapes& outputs) {
  return "inputs " + list_tensors(inputs) + "; outputs " + list_tensors(outputs);
}

Shapes get_shapes(const weir_frame& frame) {
  Shapes out;
  for (uint32_t i = 0; i < frame.n_tensors; ++i) out.push_back(model_tensor(frame.tensors[i].info));
  return out;
}

bool same(const Shapes& a, const Shapes& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const auto& x, const auto& y) {
    return x.type == y.type && x.shape == y.shape;
  });
}

int64_t now() {
  return std::chrono::nanoseconds(std::chrono::steady_clock::now().time_since_epoch()).count();
}

}  // namespace

Result<std::unique_ptr<Fallback>> Fallback::open(const FilterSettings& settings) {
  if (auto status = check_combination(settings); !status) return status.error();
  FilterSettings own;
  own.model = settings.fallback;
  own.threads = settings.threads;
  const auto source = make_model_config(own, nullptr, nullptr);
  if (!source) return source.error();
  auto lease = infer::ModelLease::create(std::make_shared<infer::SharedModel>("", *source), 1);
  if (!lease) return lease.error();
  std::unique_ptr<Fallback> out(new Fallback(settings.fallback, *std::move(lease)));
  const auto use = out->lease_->begin();
  if (!use) return use.error();
  out->inputs_ = model_tensors(use->model().inputs());
  out->outputs_ = model_tensors(use->model().outputs());
  return out;
}

FilterSettings Fallback::declare_tensors(FilterSettings s) const {
  if (s.input.empty()) s.input = dimensions_text(inputs_);
  if (s.inputtype.empty()) s.inputtype = types_text(inputs_);
  if (s.inputname.empty()) s.inputname = names_text(inputs_);
  if (s.output.empty()) s.output = dimensions_text(outputs_);
  if (s.outputtype.empty()) s.outputtype = types_text(outputs_);
  if (s.outputname.empty()) s.outputname = names_text(outputs_);
  return s;
}

Status Fallback::check(const Shapes& inputs, const Shapes& outputs) const {
  auto first = difference(inputs_, inputs, "input");
  if (first.empty()) first = difference(outputs_, outputs, "output");
  if (first.empty()) return ok();
  return Error{.code = Code::SPEC_MISMATCH,
               .what = "the fallback has other tensors than the model",
               .offered = "fallback=" + file_ + ": " + to_string(inputs_, outputs_),
               .needed = to_string(inputs, outputs),
               .difference = first,
               .fix = "set fallback to a model with the same inputs and outputs"};
}

weir_model_info Fallback::info() const {
  const auto model = lease_->shared()->model();
  return model ? model->info() : weir_model_info{};
}

Status Fallback::resolve(const infer::ModelLease::Frame& use, const Shapes& inputs,
                         const Shapes& outputs) {
  resolved_.clear();
  auto found = lease_->resolve(use, 0, inputs);
  if (!found) return found.error();
  const auto first = difference(*found, outputs, "output");
  if (!first.empty())
    return Error{.code = Code::SPEC_MISMATCH,
                 .what = "the fallback has other outputs than the model for these inputs",
                 .offered = "fallback=" + file_ + ": " + to_string(inputs, *found),
                 .needed = to_string(inputs, outputs),
                 .difference = first,
                 .fix = "set fallback to a model with the same inputs and outputs"};
  resolved_ = inputs;
  return ok();
}

Status Fallback::prepare(const Shapes& inputs, const Shapes& outputs) {
  std::lock_guard lock(mutex_);
  const auto use = lease_->begin();
  if (!use) return use.error();
  if (auto status = resolve(*use, inputs, outputs); !status) return status;
  if (auto status = infer::warm_up(use->session(), inputs, outputs); !status) return status;
  const auto begin = now();
  if (auto status = infer::invoke_zeros(use->session(), inputs, outputs); !status) return status;
  spare_.add(now() - begin);
  return ok();
}

int64_t Fallback::latest_end(int64_t expires) const {
  return spare_.latest_end(expires, now());
}

bool Fallback::has_time(int64_t expires) const {
  return spare_.is_enough(expires, now());
}

Result<bool> Fallback::invoke(const weir_frame& in, weir_frame& out, GstElement* element,
                              DropReason reason) {
  std::lock_guard lock(mutex_);
  if (!has_time(in.expires)) return false;
  const auto begin = now();
  const auto use = lease_->begin();
  if (!use) return use.error();
  const auto inputs = get_shapes(in);
  if (!same(inputs, resolved_))
    if (auto status = resolve(*use, inputs, get_shapes(out)); !status) return status.error();
  auto kept = use->session().invoke(in, out);
  spare_.add(now() - begin);
  if (!kept || !*kept) return kept;
  ++frames_;
  if (!is_active_.exchange(true))
    GST_CAT_WARNING_OBJECT(gst::get_category(element), element,
                           "the fallback %s answers: the result of the model is %s", file_.c_str(),
                           std::string(to_string(reason)).c_str());
  return true;
}

bool Fallback::model_succeeded(GstElement* element) {
  if (is_active_ && is_active_.exchange(false))
    GST_CAT_INFO_OBJECT(gst::get_category(element), element,
                        "the model answers again; the fallback %s has answered %" G_GUINT64_FORMAT
                        " frames",
                        file_.c_str(), guint64{frames_});
  return true;
}

void Fallback::add_stats(GstStructure* stats) const {
  gst_structure_set(stats, "fallback-frames", G_TYPE_UINT64, guint64{frames_}, nullptr);
}

}  // namespace weir
