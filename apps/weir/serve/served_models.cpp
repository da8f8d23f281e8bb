// SPDX-License-Identifier: LGPL-2.1-or-later
#include "serve/served_models.hpp"

#include <algorithm>
#include <filesystem>
#include <set>

#include "core/text/shell_quote.hpp"
#include "inspect/model_paths.hpp"
#include "models/catalogue.hpp"
#include "weir/join.hpp"

namespace weir::app {
namespace {

namespace fs = std::filesystem;

constexpr const char* kSample = "127.0.0.1:8001";

bool is_name(std::string_view text) {
  constexpr std::string_view kAllowed =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789._-";
  constexpr size_t kMax = 128;
  return !text.empty() && text.size() <= kMax &&
         text.find_first_not_of(kAllowed) == std::string_view::npos;
}

Result<NamedModel> read_model(const std::string& argument) {
  const size_t equals = argument.find('=');
  const bool named = equals != std::string::npos && is_name(argument.substr(0, equals));
  const std::string given = named ? argument.substr(equals + 1) : argument;
  const auto file = file_of_model(given);
  if (!file) return file.error();
  NamedModel out;
  out.file = *file;
  const auto paths = split_paths(out.file);
  for (const auto& path : paths) {
    std::error_code failed;
    if (!fs::exists(path, failed) && path.find("://") == std::string::npos)
      return Error{.code = Code::MODEL_NOT_FOUND,
                   .what = "the model file does not exist",
                   .offered = path,
                   .needed = "a model file, or a name of weir models list",
                   .fix = "weir serve /path/to/model.onnx"};
  }
  if (named)
    out.name = argument.substr(0, equals);
  else if (out.file != given)  // a name of the catalogue
    out.name = given;
  else if (!paths.empty())
    out.name = fs::path(paths.front()).stem().string();
  if (!paths.empty() && is_name(out.name)) return out;
  return Error{.code = Code::OPTION_VALUE,
               .what = "the model needs a name that fits into an address",
               .offered = "'" + argument + "'",
               .needed = "letters, digits, '.', '_' and '-'",
               .fix = "weir serve my-model=" + shell_word(out.file.empty() ? "FILE" : out.file)};
}

// An empty value leaves the default.
void add(const char* name, const std::string& value, Properties* properties) {
  if (!value.empty()) properties->emplace_back(name, value);
}

}  // namespace

Result<std::vector<NamedModel>> read_models(const std::vector<std::string>& arguments) {
  std::vector<NamedModel> out;
  std::set<std::string> names;
  for (const auto& argument : arguments) {
    auto model = read_model(argument);
    if (!model) return model.error();
    if (!names.insert(model->name).second)
      return Error{.code = Code::OPTION_VALUE,
                   .what = "two models have the same name",
                   .offered = model->name,
                   .needed = "a name for each",
                   .fix = "weir serve " + model->name + "-2=" + shell_word(model->file)};
    out.push_back(*std::move(model));
  }
  return out;
}

Status check_options(const ServeOptions& options, const ListenAddress& address) {
  const bool encrypted = !options.tls_cert.empty() && !options.tls_key.empty();
  const std::string tls = "--tls-cert server.pem --tls-key server.key";
  if (options.tls_cert.empty() != options.tls_key.empty())
    return Error{.code = Code::OPTION_VALUE,
                 .what = "a certificate and its key belong together",
                 .offered = encrypted || !options.tls_cert.empty() ? "--tls-cert without --tls-key"
                                                                   : "--tls-key without --tls-cert",
                 .needed = "both",
                 .fix = tls};
  if (!encrypted && !options.tls_ca.empty())
    return Error{.code = Code::OPTION_VALUE,
                 .what = "client certificates need a connection with TLS",
                 .offered = "--tls-ca without --tls-cert and --tls-key",
                 .needed = "a certificate of this server",
                 .fix = tls};
  if (!encrypted && !options.token_file.empty())
    return Error{.code = Code::CONNECTION_INSECURE,
                 .what = "clients would send their tokens without TLS",
                 .offered = "--token-file without --tls-cert and --tls-key",
                 .needed = "a certificate of this server",
                 .fix = tls};
  if (!encrypted && !options.insecure && !address.is_local())
    return Error{.code = Code::CONNECTION_INSECURE,
                 .what = "other machines could connect without encryption",
                 .offered = "--listen " + options.listen,
                 .needed = "TLS, or --insecure on a network that you trust",
                 .fix = tls + ", or --listen " + kSample};
  if (options.batch > 1 && options.workers > 1)
    return Error{.code = Code::OPTION_VALUE,
                 .what = "batches run one at a time",
                 .offered = "--batch " + std::to_string(options.batch) + " with --workers " +
                            std::to_string(options.workers),
                 .needed = "one of the two",
                 .fix = "weir serve " + join(options.models, " ", shell_word) + " --batch " +
                        std::to_string(options.batch)};
  return ok();
}

PipelineDescription serving_pipeline(const NamedModel& model, size_t id,
                                     const ServeOptions& options, const ListenAddress& address) {
  const std::string number = std::to_string(id);
  Properties source{{"protocol", "oip"},
                    {"id", number},
                    {"name", model.name + "-source"},
                    {"model-name", model.name}};
  add("unix-path", address.unix_path, &source);
  add("host", address.host, &source);
  add("port", address.port, &source);
  add("tls-cert", options.tls_cert, &source);
  add("tls-key", options.tls_key, &source);
  add("tls-ca", options.tls_ca, &source);
  add("token-file", options.token_file, &source);
  if (options.insecure) add("insecure", "true", &source);
  if (const auto max = options.max_connections)
    add("max-connections", std::to_string(*max), &source);
  if (const auto max = options.max_connections_of_address)
    add("max-connections-per-address", std::to_string(*max), &source);
  if (options.model_control) add("model-control", "true", &source);
  Properties filter{{"name", model.name + "-filter"}};
  add("framework", options.engine.empty() ? "auto" : options.engine, &filter);
  add("model", model.file, &filter);
  add("custom", options.custom, &filter);
  if (options.batch > 1) {
    add("batch-size", std::to_string(options.batch), &filter);
    add("batch-timeout", std::to_string(options.batch_wait_us * 1000ULL), &filter);
  }
  if (options.workers > 1) add("workers", std::to_string(options.workers), &filter);
  return PipelineDescription()
      .element("tensor_query_serversrc", std::move(source))
      .text(" ! ")
      .element("tensor_filter", std::move(filter))
      .text(" ! ")
      .element("tensor_query_serversink", {{"name", model.name + "-sink"}, {"id", number}});
}

}  // namespace weir::app
