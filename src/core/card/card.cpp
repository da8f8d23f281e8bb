// Parses model cards from JSON and checks each field by name.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/card/card.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <initializer_list>
#include <iterator>
#include <nlohmann/json.hpp>

#include "core/config/installed_file.hpp"
#include "core/text/text.hpp"
#include "core/text/unreadable.hpp"
#include "weir/join.hpp"

namespace weir::card {
namespace {

using Json = nlohmann::json;
namespace fs = std::filesystem;

constexpr size_t kBytesLimit = size_t{1} << 20;
constexpr int kDepthLimit = 16;
constexpr int64_t kSideLimit = 1 << 15;

struct Fault {
  std::string place, value, needed;
};
using Faults = std::vector<Fault>;

// Reads the fields of one object. Keeps the first fault of each field; faulty fields get defaults.
class Fields {
 public:
  Fields(const Json& object, std::string where, Faults* faults)
      : object_(object), where_(std::move(where)), faults_(*faults) {
    if (!object_.is_object()) fail("", "an object {...}");
  }

  void only(std::initializer_list<const char*> known) {
    if (!object_.is_object()) return;
    const std::vector<std::string> names(known.begin(), known.end());
    for (const auto& [key, value] : object_.items()) {
      if (std::find(names.begin(), names.end(), key) != names.end()) continue;
      const std::string close = nearest(key, names);
      fail(key, close.empty() ? "a known field of a card" : "did you mean " + close + "?");
    }
  }
  std::string text(const char* key, bool needed) {
    const Json* value = find(key, needed);
    if (!value) return "";
    if (value->is_string() && !(needed && value->get_ref<const std::string&>().empty()))
      return value->get<std::string>();
    fail(key, "a string");
    return "";
  }
  template <class T>
  T one_of(const char* key, std::initializer_list<std::pair<const char*, T>> choices, T otherwise,
           bool needed) {
    const std::string given = text(key, needed);
    if (given.empty()) return otherwise;
    for (const auto& [name, value] : choices)
      if (given == name) return value;
    fail(key, "one of " + join(choices, ", ", [](const auto& choice) { return choice.first; }));
    return otherwise;
  }
  std::vector<double> numbers(const char* key) {
    std::vector<double> out;
    const Json* value = find(key, false);
    if (!value) return out;
    const bool good = value->is_array() && std::all_of(value->begin(), value->end(), [](auto& n) {
                        return n.is_number() && std::isfinite(n.template get<double>());
                      });
    if (!good) fail(key, "a list of numbers");
    if (good) out = value->get<std::vector<double>>();
    return out;
  }
  const Json* find(const char* key, bool needed) {
    if (!object_.is_object()) return nullptr;
    const auto at = object_.find(key);
    if (at != object_.end() && !at->is_null()) return &*at;
    if (needed) fail(key, "it is required");
    return nullptr;
  }
  void fail(const std::string& key, const std::string& needed) {
    if (!object_.is_object() && !key.empty()) return;  // the object itself is the fault
    std::string place = key.empty() ? where_ : where(key);
    if (is_faulty(place)) return;
    const Json* value = object_.is_object() && object_.contains(key) ? &object_[key] : nullptr;
    const std::string shown = value ? value->dump(-1, ' ', false, Json::error_handler_t::replace)
                              : key.empty() ? object_.type_name()
                                            : "nothing";
    faults_.push_back({std::move(place), shown.substr(0, 80), needed});
  }
  bool has_fault(const std::string& key) const { return is_faulty(where(key)); }
  std::string where(const std::string& key) const { return where_ + "/" + key; }

 private:
  bool is_faulty(const std::string& place) const {
    return std::any_of(faults_.begin(), faults_.end(),
                       [&place](const Fault& fault) { return fault.place == place; });
  }

  const Json& object_;
  std::string where_;
  Faults& faults_;
};

void read_padding(Fields* fields, ImageInput* input) {
  const Json* padding = fields->find("padding", false);
  if (!padding) return;
  if (padding->is_number_unsigned() && *padding <= 255)
    input->padding = padding->get<uint8_t>();
  else
    fields->fail("padding", "a pixel value from 0 to 255");
  if (input->resize != Resize::Letterbox) fields->fail("padding", "\"resize\": \"letterbox\"");
}

void check_input(const ImageInput& input, Fields* fields) {
  const bool picture =
      (input.shape.size() == 3 || (input.shape.size() == 4 && input.shape[0] == 1)) &&
      !std::count(input.shape.begin(), input.shape.end(), 0);
  if (!picture)
    return fields->fail(
        "shape", "the extents of one picture in the order of `layout`, such as [1, 224, 224, 3]");
  if (fields->has_fault("color") || fields->has_fault("layout")) return;
  const int64_t channels = input.color == Color::Gray ? 1 : 3;
  if (input.channels() != channels)
    fields->fail("shape", std::to_string(channels) + " channels at the position given by `layout`");
  for (const char* key : {"mean", "scale"}) {
    const auto count = static_cast<int64_t>((*key == 'm' ? input.mean : input.scale).size());
    if (count > 1 && count != channels) fields->fail(key, "one number, or one for each channel");
  }
}

ImageInput input_from(const Json& json, const std::string& where, Faults* faults) {
  Fields fields(json, where, faults);
  fields.only({"name", "type", "shape", "layout", "color", "mean", "scale", "resize", "padding"});
  ImageInput input;
  input.name = fields.text("name", false);
  input.type = parse_element_type(fields.text("type", true));
  if (input.type == ElementType::End) fields.fail("type", "an element type, such as float32");
  for (const double extent : fields.numbers("shape"))
    input.shape.push_back(extent >= 1 && extent <= kSideLimit ? static_cast<int64_t>(extent) : 0);
  input.layout = fields.one_of<Layout>("layout", {{"NHWC", Layout::Nhwc}, {"NCHW", Layout::Nchw}},
                                       Layout::Nhwc, true);
  input.color = fields.one_of<Color>(
      "color", {{"RGB", Color::Rgb}, {"BGR", Color::Bgr}, {"GRAY8", Color::Gray}}, Color::Rgb,
      true);
  input.resize = fields.one_of<Resize>(
      "resize",
      {{"stretch", Resize::Stretch}, {"crop", Resize::Crop}, {"letterbox", Resize::Letterbox}},
      Resize::Stretch, false);
  read_padding(&fields, &input);
  input.mean = fields.numbers("mean");
  input.scale = fields.numbers("scale");
  check_input(input, &fields);
  return input;
}

Labels labels_from(Fields* fields, Faults* faults) {
  Labels out;
  const Json* value = fields->find("labels", false);
  if (!value) return out;
  if (value->is_object()) {
    Fields file(*value, fields->where("labels"), faults);
    file.only({"file", "skip"});
    out.file = file.text("file", true);
    if (out.file.find('/') != std::string::npos) file.fail("file", "a file name without folders");
    if (const Json* skip = file.find("skip", false)) {
      if (skip->is_number_unsigned()) out.skip = skip->get<size_t>();
      if (!skip->is_number_unsigned()) file.fail("skip", "a number of lines");
    }
    return out;
  }
  const bool texts =
      value->is_array() &&
      std::all_of(value->begin(), value->end(), [](auto& label) { return label.is_string(); });
  if (texts) out.names = value->get<std::vector<std::string>>();
  if (!texts) fields->fail("labels", "a list of strings, or {\"file\": ..., \"skip\": ...}");
  return out;
}

std::vector<std::pair<std::string, std::string>> decoder_options_from(Fields* fields,
                                                                      Faults* faults) {
  std::vector<std::pair<std::string, std::string>> out;
  const Json* value = fields->find("decoder_options", false);
  if (!value) return out;
  Fields options(*value, fields->where("decoder_options"), faults);
  if (!value->is_object()) return out;
  for (const auto& [name, option] : value->items()) {
    if (option.is_string())
      out.emplace_back(name, option.get<std::string>());
    else
      options.fail(name, "a string: the value of this property of tensor_decoder");
  }
  return out;
}

Card card_from(const Json& json, const std::string& place, Faults* faults) {
  Fields fields(json, place, faults);
  fields.only({"name", "model", "sha256", "task", "inputs", "outputs", "labels", "decoder",
               "decoder_options", "provenance"});
  Card card;
  card.name = fields.text("name", true);
  card.model = fields.text("model", true);
  card.task = fields.text("task", false);
  card.sha256 = lower(fields.text("sha256", true));
  if (card.sha256.size() != 64 ||
      card.sha256.find_first_not_of("0123456789abcdef") != std::string::npos)
    fields.fail("sha256", "64 hexadecimal digits: sha256sum MODEL");
  card.decoder = fields.text("decoder", false);
  card.decoder_options = decoder_options_from(&fields, faults);
  card.labels = labels_from(&fields, faults);
  const Json* provenance = fields.find("provenance", true);
  if (provenance && !provenance->is_object())
    fields.fail("provenance", "an object: source, licence");
  const Json* inputs = fields.find("inputs", true);
  if (inputs && (!inputs->is_array() || inputs->empty()))
    fields.fail("inputs", "a list of at least one input");
  if (inputs && inputs->is_array())
    for (size_t i = 0; i < inputs->size(); ++i)
      card.inputs.push_back(
          input_from((*inputs)[i], fields.where("inputs") + "/" + std::to_string(i), faults));
  return card;
}

Error invalid(const std::string& offered, const std::string& needed) {
  return Error{.code = Code::CARD_INVALID,
               .what = "the model card cannot be used",
               .offered = offered,
               .needed = needed,
               .fix = "docs/cards.md lists the fields of a card"};
}

// The first fault, and the others below it.
Error invalid(const Faults& faults) {
  Error out = invalid(faults[0].place + ": " + faults[0].value, faults[0].needed);
  const size_t others = faults.size() - 1;
  if (others == 0) return out;
  out.difference = std::to_string(others) + (others == 1 ? " more error:" : " more errors:");
  for (size_t i = 1; i < faults.size(); ++i)
    out.difference +=
        "\n    " + faults[i].place + ": " + faults[i].value + ", needed: " + faults[i].needed;
  return out;
}

Error not_read(const std::string& path) {
  Error out{.code = Code::FILE_NOT_FOUND,
            .what = "the model card cannot be read",
            .offered = path,
            .needed = "a file that can be read",
            .difference = why_unreadable(path),
            .fix = "the path of a card; docs/cards.md describes its fields"};
  if (const auto installed = config::installed_file(path); !installed.empty()) {
    out.difference = "Weir is installed below another prefix";
    out.fix = "card=" + installed;
  }
  return out;
}

}  // namespace

int64_t ImageInput::width() const noexcept {
  return shape[shape.size() - (layout == Layout::Nhwc ? 2 : 1)];
}
int64_t ImageInput::height() const noexcept {
  return shape[shape.size() - (layout == Layout::Nhwc ? 3 : 2)];
}
int64_t ImageInput::channels() const noexcept {
  return shape[shape.size() - (layout == Layout::Nhwc ? 1 : 3)];
}

Result<Card> parse(std::string_view text, const std::string& place) {
  if (text.size() > kBytesLimit)
    return invalid(place + ": " + std::to_string(text.size()) + " bytes",
                   "a card of at most 1 MiB");
  // Deeper than any card: rejected while parsing, so that nesting costs no memory.
  bool too_deep = false;
  const auto bounded = [&too_deep](int depth, Json::parse_event_t, Json&) {
    too_deep |= depth > kDepthLimit;
    return !too_deep;
  };
  Json json;
  try {
    json = Json::parse(text, bounded);
  } catch (const Json::parse_error& error) {
    return invalid(place + ": not JSON at byte " + std::to_string(error.byte), "JSON");
  } catch (const Json::exception&) {  // a number out of range
    return invalid(place + ": a number that is too large",
                   "JSON with numbers that fit into 64 bits");
  }
  if (too_deep) return invalid(place + ": objects that are nested too deeply", "a card");
  Faults faults;
  Card card = card_from(json, place, &faults);
  if (!faults.empty()) return invalid(faults);
  return card;
}

Result<Card> read(const std::string& path) {
  std::error_code ignored;
  if (!fs::is_regular_file(path, ignored)) return not_read(path);  // opening a FIFO would wait
  std::ifstream file(path, std::ios::binary);
  if (!file.is_open()) return not_read(path);
  std::string text(kBytesLimit + 1, '\0');
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<size_t>(file.gcount()));
  auto card = parse(text, path);
  if (card) card->path = path;
  return card;
}

}  // namespace weir::card
