// SPDX-License-Identifier: LGPL-2.1-or-later
#include "oip/oip_options.hpp"

#include <algorithm>

#include "weir/engine_tools.hpp"

namespace weir::engine {
namespace {

constexpr const char* kKnown =
    "attempts, ca, cert, contents, idempotent, in-flight, insecure, key, max-message, probe-ms, "
    "timeout-ms, token-file";
constexpr int kMaxMebibytes = 2047;  // gRPC counts bytes of a message in 31 bits

Status read_contents(std::string_view value, OipOptions* out) {
  if (value == "raw")
    out->contents = net::Contents::Raw;
  else if (value == "typed")
    out->contents = net::Contents::Typed;
  else if (value != "auto")
    return bad_option("contents", value, "auto, raw or typed", "auto");
  return ok();
}

// True if `key` is the name of a file.
bool take_file(std::string_view key, std::string_view value, net::Security* out) {
  const struct {
    const char* key;
    std::string* path;
  } files[] = {
      {"ca", &out->ca}, {"cert", &out->cert}, {"key", &out->key}, {"token-file", &out->token_file}};
  for (const auto& file : files)
    if (equals_ignoring_case(key, file.key)) {
      *file.path = value;
      return true;
    }
  return false;
}

// False if `key` is no option that is a number.
Result<bool> take_number(std::string_view key, std::string_view value, OipOptions* out) {
  static constexpr const char* kNumbers[] = {"in-flight", "attempts", "timeout-ms", "probe-ms",
                                             "max-message"};
  const auto* const found =
      std::find_if(std::begin(kNumbers), std::end(kNumbers),
                   [key](const char* name) { return equals_ignoring_case(key, name); });
  if (found == std::end(kNumbers)) return false;
  const auto number = number_option(key, value, 1);
  if (!number) return number.error();
  switch (found - std::begin(kNumbers)) {
    case 0:
      out->limits.in_flight = static_cast<size_t>(*number);
      break;
    case 1:
      out->limits.attempts = *number;
      break;
    case 2:
      out->limits.timeout = std::chrono::milliseconds(*number);
      break;
    case 3:
      out->limits.probe = std::chrono::milliseconds(*number);
      break;
    default:
      out->max_bytes = static_cast<size_t>(std::min(*number, kMaxMebibytes)) << 20;
  }
  return true;
}

Status take_other(std::string_view key, std::string_view value, OipOptions* out) {
  if (equals_ignoring_case(key, "contents")) return read_contents(value, out);
  const bool insecure = equals_ignoring_case(key, "insecure");
  if (!insecure && !equals_ignoring_case(key, "idempotent")) {
    warn_unknown_option(key, kKnown);
    return ok();
  }
  const auto flag = switch_option(key, value);
  if (!flag) return flag.error();
  (insecure ? out->security.insecure : out->idempotent) = *flag;
  return ok();
}

}  // namespace

Result<OipOptions> OipOptions::read(const weir_open& request) {
  OipOptions out;
  for (uint32_t i = 0; request.options && i < request.n_options; ++i) {
    const auto key = text_or_empty(request.options[i].key);
    const auto value = text_or_empty(request.options[i].value);
    const auto declared = out.declared.take(key, value);
    if (!declared) return declared.error();
    if (*declared || take_file(key, value, &out.security)) continue;
    const auto number = take_number(key, value, &out);
    if (!number) return number.error();
    if (*number) continue;
    if (auto status = take_other(key, value, &out); !status) return status.error();
  }
  if (!out.idempotent) out.limits.attempts = 1;
  return out;
}

}  // namespace weir::engine
