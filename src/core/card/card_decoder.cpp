// Checks the mode and each option against the table of modes.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/card/card_decoder.hpp"

#include <algorithm>
#include <optional>
#include <string_view>

#include "core/card/decoder_modes.hpp"
#include "core/text/text.hpp"

namespace weir::card {
namespace {

namespace fs = std::filesystem;

constexpr uint64_t kMostCount = 65536;

// Modes that run code: a card cannot choose them, the line of a pipeline can.
constexpr std::pair<std::string_view, const char*> kCode[] = {
    {"python3", "option1=/path/to/script.py"}, {"custom-code", "option1=NAME"}};

std::string names_of_modes() {
  return join(decoder_modes(), ", ",
              [](const DecoderMode& mode) { return std::string(mode.name); });
}

// Lists the names of the properties, or the keys of `custom`.
std::string names_of_options(const DecoderMode& mode, bool are_properties) {
  std::string out;
  for (const DecoderOption& option : mode.options)
    if (!are_properties || is_decoder_property(option))
      out += (out.empty() ? "" : ", ") + std::string(option.name);
  if (are_properties && !mode.is_numbered()) out += ", custom";
  return out;
}

std::string needed_option(const DecoderMode& mode, const std::string& given, bool is_property) {
  const std::string names = names_of_options(mode, is_property);
  if (names.empty()) return "no option: mode=" + std::string(mode.name) + " has none";
  std::vector<std::string> all;
  for (const auto name : split(names, ",")) all.emplace_back(strip(name));
  const std::string close = nearest(given, all);
  return (close.empty() ? "" : "did you mean " + close + "? ") + "mode=" + std::string(mode.name) +
         " has " + names;
}

// Names what the user can do instead: set a property of an element, or an option of the command.
std::string needed_file(const DecoderOption& option) {
  const std::string elsewhere = option.name == "labels"
                                    ? "--labels FILE of weir try and weir evaluate"
                                    : "tensor_decoder in a pipeline of your own";
  return "the name of a file beside the card, without folders; for any other file, use " +
         elsewhere;
}

// Reads the value of one option. Texts of files get the folder of the card.
class OptionReader {
 public:
  OptionReader(const DecoderMode& mode, const fs::path& folder, std::string scheme)
      : mode_(mode), folder_(folder), scheme_(std::move(scheme)) {}

  // Returns nullopt, and what is needed, for a value that the option cannot have.
  std::optional<std::string> read(const DecoderOption& option, const std::string& value) {
    switch (option.value) {
      case Value::Text:
        return value;
      case Value::Fraction: {
        const auto number = parse_double(value);
        if (value.empty() || (number && *number >= 0 && *number <= 1)) return value;
        return refuse("a number from 0 to 1, as text");
      }
      case Value::Count: {
        const auto number = parse_unsigned(value);
        if (value.empty() || (number && *number <= kMostCount)) return value;
        return refuse("a whole number from 0 to 65536, as text");
      }
      case Value::File:
        return files(option, value, "");
      case Value::Files:
        return files(option, value, ";");
      case Value::FileFirst:
        return file_first(option, value);
      case Value::Parameters:
        return starts_with_file() ? file_first(option, value) : value;
    }
    return std::nullopt;
  }

  // Reads the value of the property custom: key:value,key:value.
  std::optional<std::string> read_custom(const std::string& text) {
    std::string out;
    for (const auto part : split(text, ",")) {
      const auto item = strip(part);
      if (item.empty()) continue;
      const size_t colon = item.find(':');
      const std::string key(strip(item.substr(0, colon)));
      if (colon == std::string_view::npos) return refuse("key:value for each option, with commas");
      const DecoderOption* option = mode_.option(key);
      if (!option) return refuse(needed_option(mode_, key, false));
      const auto value = read(*option, std::string(strip(item.substr(colon + 1))));
      if (!value) return std::nullopt;
      // A comma of the folder would begin another option.
      if (value->find(',') != std::string::npos) return refuse_folder(",");
      out += (out.empty() ? "" : ",") + key + ":" + *value;
    }
    return out;
  }

  const std::string& needed() const noexcept { return needed_; }

 private:
  std::optional<std::string> refuse(std::string needed) {
    needed_ = std::move(needed);
    return std::nullopt;
  }
  std::optional<std::string> refuse_folder(const std::string& separator) {
    return refuse("a card in a folder whose path has no \"" + separator +
                  "\", which separates the parts of this value");
  }
  // Returns whether the scheme of bounding_boxes is the one that reads prior boxes from a file.
  bool starts_with_file() const {
    return equal_ignoring_case(scheme_, "mobilenet-ssd") ||
           equal_ignoring_case(scheme_, "tflite-ssd");
  }

  std::optional<std::string> files(const DecoderOption& option, const std::string& value,
                                   std::string_view separator) {
    if (value.empty()) return value;
    std::string out;
    for (const auto name : split(value, separator)) {
      if (!is_name_of_a_file(name)) return refuse(needed_file(option));
      out += (out.empty() ? "" : std::string(separator)) + (folder_ / name).string();
    }
    if (!separator.empty() && folder_.string().find(separator) != std::string::npos)
      return refuse_folder(std::string(separator));
    return out;
  }

  std::optional<std::string> file_first(const DecoderOption& option, const std::string& value) {
    const size_t colon = std::min(value.find(':'), value.size());
    const auto file = files(option, value.substr(0, colon), "");
    if (!file) return std::nullopt;
    if (file->find(':') != std::string::npos) return refuse_folder(":");
    return *file + value.substr(colon);
  }

  const DecoderMode& mode_;
  const fs::path& folder_;
  const std::string scheme_;
  std::string needed_;
};

std::string text_of(const Json& object, const char* key) {
  return object.contains(key) && object[key].is_string() ? object[key].get<std::string>() : "";
}

}  // namespace

std::string decoder_from(Fields* fields) {
  std::string mode = fields->text("decoder", false);
  if (mode.empty() || find_decoder_mode(mode)) return mode;
  for (const auto& [name, options] : kCode)
    if (equal_ignoring_case(mode, name)) {
      fields->fail("decoder", "a mode that runs no code: " + names_of_modes() +
                                  "; to run your own, write tensor_decoder mode=" +
                                  std::string(name) + " " + options + " into a pipeline");
      return "";
    }
  std::vector<std::string> names;
  for (const DecoderMode& known : decoder_modes()) names.emplace_back(known.name);
  const std::string close = nearest(mode, names);
  fields->fail("decoder", close.empty()
                              ? "null, or a mode that comes with Weir: " + names_of_modes()
                              : "did you mean " + close + "?");
  return "";
}

std::vector<std::pair<std::string, std::string>> decoder_options_from(Fields* fields,
                                                                      const std::string& mode_name,
                                                                      const fs::path& folder,
                                                                      Faults* faults) {
  std::vector<std::pair<std::string, std::string>> out;
  const Json* given = fields->find("decoder_options", false);
  if (!given) return out;
  Fields options(*given, fields->where("decoder_options"), faults);
  if (!given->is_object() || fields->has_fault("decoder")) return out;
  const DecoderMode* mode = find_decoder_mode(mode_name);
  if (!mode && !given->empty()) fields->fail("decoder_options", "a decoder that has these options");
  if (!mode) return out;
  OptionReader reader(*mode, folder, text_of(*given, "option1"));
  for (const auto& [name, json] : given->items()) {
    const bool is_custom = name == "custom" && !mode->is_numbered();
    const DecoderOption* option = mode->option(name);
    if (!is_custom && !(option && is_decoder_property(*option))) {
      options.fail(name, needed_option(*mode, name, true));
    } else if (!json.is_string()) {
      options.fail(name, "a string: the value of this property of tensor_decoder");
    } else if (const auto text = json.get<std::string>(); !is_plain_text(text)) {
      options.fail(name, kPlainText);
    } else if (auto value = is_custom ? reader.read_custom(text) : reader.read(*option, text)) {
      out.emplace_back(name, *std::move(value));
    } else {
      options.fail(name, reader.needed());
    }
  }
  return out;
}

}  // namespace weir::card
