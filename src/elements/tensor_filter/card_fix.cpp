// Finds the card by the digest of the model's file.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_filter/card_fix.hpp"

#include "core/card/find.hpp"
#include "core/text/shell_quote.hpp"
#include "gstcpp/element/file_digest.hpp"

namespace weir {
namespace {

// Whether tensor_preprocess with the card makes a tensor for the model.
bool describes(const card::ImageInput& input, const ModelTensor& needed) {
  if (input.type != needed.type || input.shape.size() != needed.shape.size()) return false;
  for (size_t i = 0; i < needed.shape.size(); ++i)
    if (needed.shape[i] >= 0 && needed.shape[i] != input.shape[i]) return false;
  return true;
}

}  // namespace

Error with_card(Error error, const std::string& model_path,
                const std::vector<ModelTensor>& inputs) {
  const bool has_other_fix = error.fix.starts_with("tensor_filter ");  // invoke-rows
  if (error.code != Code::SPEC_MISMATCH || has_other_fix || model_path.empty() ||
      inputs.size() != 1)
    return error;
  card::Search search;
  search.model = model_path;
  search.sha256 = [&model_path] { return gst::sha256_of(model_path); };
  search.folders = card::card_folders();
  const auto card = card::find(search);
  if (card && !card->path.empty() && card->inputs.size() == 1 &&
      describes(card->inputs[0], inputs[0]))
    error.fix = "tensor_preprocess card=" + launch_value(card->path) +
                " ! tensor_filter, directly after the video, without tensor_converter";
  return error;
}

}  // namespace weir
