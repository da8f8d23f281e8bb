// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/dataset/description.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "core/text/error_text.hpp"
#include "core/text/json_depth.hpp"
#include "core/text/shell_quote.hpp"

namespace weir::dataset {
namespace {

using Json = nlohmann::json;

constexpr int kDepthLimit = 64;

// What stops the reading. Caught in parse_description().
struct Refused {
  Error error;
};

class DescriptionReader {
 public:
  DescriptionReader(const std::string& path, const Json& root) : path_(path), root_(root) {}

  Description read() const {
    if (!root_.is_object()) refuse("it is not an object", shown(root_), "{\"gst_caps\" : ...}");
    Description out;
    out.caps = text("gst_caps");
    out.total_samples = number(needed("total_samples"), "total_samples");
    if (const Json* size = find("sample_size")) out.sample_size = number(*size, "sample_size");
    if (find("sample_offset") || find("tensor_size") || find("tensor_count"))
      out.sizes = {numbers("sample_offset"), numbers("tensor_size"), numbers("tensor_count")};
    return out;
  }

 private:
  [[noreturn]] void refuse(const std::string& what, const std::string& offered,
                           std::string needed) const {
    throw Refused{{.code = Code::SAMPLES_INVALID,
                   .what = "the description of the samples cannot be used: " + what,
                   .offered = path_ + ": " + offered,
                   .needed = std::move(needed),
                   .fix = "let datareposink write the file again, or correct it: python3 -m "
                          "json.tool " +
                          shell_word(path_)}};
  }
  static std::string shown(const Json& value) {
    std::string out = value.dump(-1, ' ', false, Json::error_handler_t::replace);
    if (out.size() > 60) out = out.substr(0, 60) + "...";
    return out;
  }

  const Json* find(const char* name) const {
    const auto at = root_.find(name);
    return at == root_.end() ? nullptr : &*at;
  }
  const Json& needed(const char* name) const {
    if (const Json* value = find(name)) return *value;
    refuse("a member is missing", std::string("no \"") + name + "\"",
           std::string("\"") + name + "\"");
  }
  std::string text(const char* name) const {
    const Json& value = needed(name);
    if (value.is_string()) return value.get<std::string>();
    refuse(std::string(name) + " is not a string", shown(value), "caps such as \"image/png\"");
  }
  uint64_t number(const Json& value, const std::string& name) const {
    if (value.is_number_unsigned()) return value.get<uint64_t>();
    refuse(name + " is not a number of bytes or samples", shown(value),
           "a whole number, 0 or more");
  }
  std::vector<uint64_t> numbers(const char* name) const {
    const Json& list = needed(name);
    if (!list.is_array())
      refuse(std::string(name) + " is not an array", shown(list), "an array of whole numbers");
    std::vector<uint64_t> out;
    out.reserve(list.size());
    for (const Json& value : list)
      out.push_back(number(value, std::string(name) + "[" + std::to_string(out.size()) + "]"));
    return out;
  }

  const std::string& path_;
  const Json& root_;
};

Error not_json(const std::string& path, std::string why) {
  return Error{.code = Code::SAMPLES_INVALID,
               .what = "the description of the samples is not JSON",
               .offered = path,
               .needed = "the JSON file that datareposink wrote",
               .difference = std::move(why),
               .fix = "python3 -m json.tool " + shell_word(path)};
}

void append_list(const char* name, const std::vector<uint64_t>& list, std::string* out) {
  *out += std::string(",\n  \"") + name + "\" : [";
  for (size_t i = 0; i < list.size(); ++i)
    *out += (i == 0 ? "\n    " : ",\n    ") + std::to_string(list[i]);
  *out += list.empty() ? "]" : "\n  ]";
}

}  // namespace

Result<Description> parse_description(const std::string& path, std::string_view text) {
  if (json_depth(text) > kDepthLimit) return not_json(path, "it is nested too deeply");
  try {
    const Json root = Json::parse(text);
    return DescriptionReader(path, root).read();
  } catch (const Json::parse_error& error) {
    const size_t byte = std::max<size_t>(error.byte, 1) - 1;
    return not_json(path, place_in(text, std::min(byte, text.size())));
  } catch (const Json::out_of_range&) {  // 1e999
    return not_json(path, "a number is too large");
  } catch (const Refused& refused) {
    return refused.error;
  }
}

std::string to_json(const Description& description) {
  const std::string caps =
      Json(description.caps).dump(-1, ' ', false, Json::error_handler_t::replace);
  std::string out = "{\n  \"gst_caps\" : " + caps +
                    ",\n  \"total_samples\" : " + std::to_string(description.total_samples);
  if (description.sample_size)
    out += ",\n  \"sample_size\" : " + std::to_string(*description.sample_size);
  if (description.sizes) {
    append_list("sample_offset", description.sizes->sample_offset, &out);
    append_list("tensor_size", description.sizes->tensor_size, &out);
    append_list("tensor_count", description.sizes->tensor_count, &out);
  }
  return out + "\n}";
}

}  // namespace weir::dataset
