// Reading a model file.
#include "model_bytes.hpp"

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <system_error>

namespace weir::engine {
namespace {

namespace fs = std::filesystem;

Error not_found(const std::string& path, const std::string& why) {
  return Error{Code::MODEL_NOT_FOUND,
               "the model file cannot be read",
               path + ": " + why,
               "a regular file that this user may read",
               "",
               "model=/path/to/the/model"};
}

}  // namespace

Result<ModelBytes> read_model(const weir_open& request) {
  ModelBytes out;
  if (request.n_models == 0 && request.bytes && request.n_bytes > 0) {
    out.bytes = {static_cast<const std::byte*>(request.bytes), request.n_bytes};
    return out;
  }
  if (request.n_models != 1 || !request.paths || !request.paths[0])
    return Error{Code::SPEC_MISMATCH,
                 "this engine takes exactly one model file",
                 std::to_string(request.n_models) + " files",
                 "1 file",
                 "",
                 "model=NAME"};
  out.path = request.paths[0];
  std::error_code failed;
  const auto status = fs::status(out.path, failed);
  if (!fs::exists(status)) return not_found(out.path, std::strerror(ENOENT));
  if (!fs::is_regular_file(status)) return not_found(out.path, "not a regular file");
  const auto size = fs::file_size(out.path, failed);
  if (failed) return not_found(out.path, failed.message());
  std::ifstream file(out.path, std::ios::binary);
  if (!file) return not_found(out.path, std::strerror(errno));
  out.owned.resize(size);
  file.read(reinterpret_cast<char*>(out.owned.data()), static_cast<std::streamsize>(size));
  out.owned.resize(static_cast<size_t>(std::max<std::streamsize>(file.gcount(), 0)));
  if (out.owned.empty())
    return Error{Code::MODEL_INVALID, "the model file is empty", out.path, "a model", "", ""};
  out.bytes = out.owned;
  return out;
}

}  // namespace weir::engine
