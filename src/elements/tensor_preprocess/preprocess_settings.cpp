// Properties become a request.
#include "elements/tensor_preprocess/preprocess_settings.hpp"

namespace weir {
namespace {

template <class Value, class Choice>
std::optional<Value> chosen(Choice choice) {
  if (choice == Choice::Auto) return std::nullopt;
  return static_cast<Value>(choice);
}

}  // namespace

Result<preprocess::Request> request_of(const PreprocessSettings& s) {
  preprocess::Request request;
  request.width = s.width;
  request.height = s.height;
  request.resize = s.method;
  request.padding = s.padding_value;
  request.fit = chosen<preprocess::Fit>(s.fit);
  request.order = chosen<preprocess::ChannelOrder>(s.channel_order);
  request.layout = chosen<preprocess::Layout>(s.layout);
  if (!s.mean.empty()) {
    auto mean = preprocess::parse_numbers("mean", s.mean);
    if (!mean) return mean.error();
    request.mean = *std::move(mean);
  }
  if (!s.scale.empty()) {
    auto scale = preprocess::parse_numbers("scale", s.scale);
    if (!scale) return scale.error();
    request.scale = *std::move(scale);
  }
  if (!s.quantisation.empty()) {
    auto quantisation = preprocess::parse_quantisation(s.quantisation);
    if (!quantisation) return quantisation.error();
    request.quantisation = *quantisation;
  }
  if (!s.type.empty()) {
    auto type = preprocess::parse_type(s.type);
    if (!type) return type.error();
    request.type = *type;
  }
  if (s.card.empty()) return request;
  const auto card = card::read(s.card);
  if (!card) return card.error();
  return preprocess::with_card(std::move(request), *card);
}

}  // namespace weir
