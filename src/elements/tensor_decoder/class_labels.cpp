// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_decoder/class_labels.hpp"

#include <algorithm>
#include <utility>

#include "core/card/find_card.hpp"
#include "gstcpp/element/file_digest.hpp"

namespace weir {
namespace {

// Whether the model has an input of this type and shape, which may be open.
bool has_input(const DescribedModel& model, const card::ImageInput& input) {
  const auto fits = [](int64_t own, int64_t given) { return own < 0 || own == given; };
  return std::any_of(model.inputs.begin(), model.inputs.end(), [&](const ModelTensor& own) {
    return own.type == input.type && std::equal(own.shape.begin(), own.shape.end(),
                                                input.shape.begin(), input.shape.end(), fits);
  });
}

}  // namespace

void ClassLabels::clear() {
  received_.clear();
  sent_ = {};
}

void ClassLabels::receive(GstEvent* event, FrameDecoder* decoder) {
  auto labels = gst::parse_labels_event(event);
  if (!labels) return;
  if (decoder) decoder->set_labels(*labels);
  const std::string source = labels->source;
  received_.insert_or_assign(source, *std::move(labels));
}

void ClassLabels::pass_to(FrameDecoder* decoder) const {
  for (const auto& [source, labels] : received_) decoder->set_labels(labels);
}

void ClassLabels::send(const FrameDecoder& decoder, const std::string& source, GstPad* pad) {
  gst::LabelsOfSource labels{source, decoder.labels()};
  if (labels == sent_ || (labels.labels.empty() && sent_.labels.empty())) return;
  sent_ = std::move(labels);
  gst_pad_push_event(pad, gst::make_labels_event(sent_).release());
}

std::optional<Error> ClassLabels::missing(const FrameDecoder& decoder, const std::string& file) {
  const size_t labels = decoder.labels().size(), classes = decoder.classes();
  if (labels == 0 || labels >= classes) return std::nullopt;
  Error error{.code = Code::LABELS_INVALID,
              .what = "there are fewer labels than classes; the other classes are shown as numbers",
              .offered = std::to_string(labels) + " labels of " +
                         (file.empty() ? "the model or its card" : "labels=" + file),
              .needed = std::to_string(classes) + " labels, one for each class of the model",
              .fix = "tensor_decoder labels=FILE with a line for each class"};
  std::string text = error.message();
  if (text == reported_) return std::nullopt;
  reported_ = std::move(text);
  return error;
}

void ClassLabels::add_card_labels(DescribedModel* model) {
  if (model->path.empty()) return;
  if (card_of_ != model->path) {
    card_of_ = model->path;
    card_labels_ = card::find_labels(
        model->path, [&](const card::ImageInput& input) { return has_input(*model, input); },
        [&] { return gst::known_sha256(model->path); }, card::card_folders());
  }
  model->card_labels = card_labels_;
}

}  // namespace weir
