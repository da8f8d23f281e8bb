// For tests of the engine oip: a server of Python's grpcio in another process, and the engine's C
// table with a frame of one tensor.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstring>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "becomes.hpp"
#include "engine_host_test_support.hpp"
#include "weir/abi.h"

namespace weir::engine_test {

// A Python script that prints `port PORT` when it listens. Ends with the object.
class PythonProcess {
 public:
  PythonProcess(const char* script, std::vector<std::string> arguments) {
    int out[2], in[2];
    if (pipe2(out, O_CLOEXEC) != 0 || pipe2(in, O_CLOEXEC) != 0) return;
    arguments.insert(arguments.begin(), {"/usr/bin/python3", script});
    std::vector<char*> argv;
    for (auto& argument : arguments) argv.push_back(argument.data());
    argv.push_back(nullptr);
    process_ = fork();
    if (process_ == 0) {
      dup2(in[0], 0);
      dup2(out[1], 1);
      execv(argv[0], argv.data());
      _exit(127);
    }
    close(in[0]);
    close(out[1]);
    input_ = in[1];
    output_ = out[0];
    const std::string line = next_line();
    if (line.rfind("port ", 0) == 0) port_ = line.substr(5);
  }
  ~PythonProcess() {
    end();
    if (input_ >= 0) close(input_);
    if (output_ >= 0) close(output_);
  }
  PythonProcess(const PythonProcess&) = delete;
  PythonProcess& operator=(const PythonProcess&) = delete;

  const std::string& port() const { return port_; }  // "" when it did not start
  // Writes a line and returns the next one of the process.
  std::string response_to(const std::string& line) const {
    const std::string sent = line + "\n";
    EXPECT_EQ(write(input_, sent.data(), sent.size()), ssize_t(sent.size()));
    return next_line();
  }
  // SIGSTOP: returns when all threads have stopped.
  void signal(int number) const {
    kill(process_, number);
    if (number == SIGSTOP) waitpid(process_, nullptr, WUNTRACED);
  }
  void end() {
    if (process_ <= 0) return;
    kill(process_, SIGKILL);
    waitpid(process_, nullptr, 0);
    process_ = -1;
  }

 private:
  std::string next_line() const {
    std::string line;
    for (char next = 0; read(output_, &next, 1) == 1 && next != '\n';) line += next;
    return line;
  }

  pid_t process_ = -1;
  int input_ = -1, output_ = -1;
  std::string port_;
};

inline std::string affine_at(const std::string& port, const std::string& scheme = "grpc") {
  return scheme + "://127.0.0.1:" + port + "/affine/1";
}

// tests/support/inference_server.py.
class PythonServer : public PythonProcess {
 public:
  explicit PythonServer(std::vector<std::string> arguments = {})
      : PythonProcess(WEIR_INFERENCE_SERVER, with_classes(std::move(arguments))) {}
  std::string address(const std::string& scheme = "grpc") const {
    return affine_at(port(), scheme);
  }

 private:
  static std::vector<std::string> with_classes(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), {"--classes", WEIR_INFERENCE_CLASSES});
    return arguments;
  }
};

// A model on a server, through the C table.
class OipEngine {
 public:
  using Options = std::vector<std::pair<std::string, std::string>>;
  OipEngine(const std::vector<std::string>& addresses, const Options& options = {})
      : engine_(*load_module(WEIR_MODULE_FILE)) {
    std::vector<const char*> paths;
    for (const auto& address : addresses) paths.push_back(address.c_str());
    std::vector<weir_option> pairs;
    for (const auto& [key, value] : options) pairs.push_back({key.c_str(), value.c_str()});
    weir_open request{};
    request.struct_size = sizeof request;
    request.paths = paths.data();
    request.n_models = static_cast<uint32_t>(paths.size());
    request.options = pairs.data();
    request.n_options = static_cast<uint32_t>(pairs.size());
    weir_error error;
    if (engine_.open(&request, &model_, &error) < 0) {
      error_ = error.error;
      return;
    }
    info_.struct_size = sizeof info_;
    EXPECT_EQ(engine_.info(model_, &info_, &error), 0);
    EXPECT_EQ(engine_.session_new(model_, nullptr, 0, &session_, &error), 0);
  }
  ~OipEngine() {
    if (session_) engine_.session_free(session_);
    if (model_) engine_.close(model_);
  }
  OipEngine(const OipEngine&) = delete;
  OipEngine& operator=(const OipEngine&) = delete;

  const Error& error() const { return error_; }  // of open(); what is "" on success
  const weir_model_info& info() const { return info_; }

  struct Result {
    int code = 0;  // of invoke: 0, a weir_no_result, or below 0 = an error
    Error error;
    std::vector<std::byte> bytes;
    std::vector<int64_t> shape;
  };
  // `expires`: milliseconds from now; 0 = none. `room`: bytes of memory for the output; 0: the
  // engine allocates.
  Result invoke(const TestTensor& input, int expires = 0, size_t room = 0) {
    if (!session_) {
      ADD_FAILURE() << "the model was not opened: " << error_.message();
      return {.code = -1, .error = error_, .bytes = {}, .shape = {}};
    }
    weir_tensor in{}, out{};
    in.data = const_cast<std::byte*>(input.bytes.data());
    in.bytes = in.capacity = input.bytes.size();
    in.info = input.info;
    Result result;
    result.bytes.resize(room);
    out.info = input.info;
    if (room > 0) out.data = result.bytes.data();
    out.bytes = out.capacity = room;
    weir_frame in_frame{}, out_frame{};
    in_frame.struct_size = out_frame.struct_size = sizeof in_frame;
    in_frame.n_tensors = out_frame.n_tensors = 1;
    in_frame.tensors = &in;
    out_frame.tensors = &out;
    const auto now = std::chrono::steady_clock::now().time_since_epoch();
    if (expires > 0)
      in_frame.expires = std::chrono::nanoseconds(now + std::chrono::milliseconds(expires)).count();
    weir_error error;
    result.code = engine_.invoke(session_, &in_frame, &out_frame, &error);
    result.error = error.error;
    result.shape = to_shape(out.info);
    if (out.release) {
      const auto* data = static_cast<const std::byte*>(out.data);
      result.bytes.assign(data, data + out.bytes);
      out.release(out.owner);
    }
    return result;
  }
  std::map<std::string, uint64_t> statistics() const {
    const auto* calls =
        static_cast<const weir_engine_statistics*>(engine_.extension(WEIR_ENGINE_STATISTICS));
    weir_statistic all[32] = {};
    const int count = calls ? calls->read(model_, all, 32) : 0;
    std::map<std::string, uint64_t> out;
    for (int i = 0; i < count; ++i) out[all[i].name] = all[i].value;
    return out;
  }
  std::vector<weir_server> servers() const {
    const auto* calls =
        static_cast<const weir_engine_servers*>(engine_.extension(WEIR_ENGINE_SERVERS));
    std::vector<weir_server> out(8);
    out.resize(calls ? calls->read(model_, out.data(), 8) : 0);
    return out;
  }
  // "" if no server has answered the calling thread.
  std::string answered_by() const {
    const auto* calls =
        static_cast<const weir_engine_servers*>(engine_.extension(WEIR_ENGINE_SERVERS));
    const char* server = calls ? calls->answered_by(session_) : nullptr;
    return server ? server : "";
  }

 private:
  const weir_engine& engine_;
  weir_model* model_ = nullptr;
  weir_session* session_ = nullptr;
  weir_model_info info_{};
  Error error_{};
};

// For a short timeout-ms, which is also the time that a busy server has to describe its model.
inline std::unique_ptr<OipEngine> opened(const std::vector<std::string>& addresses,
                                         const OipEngine::Options& options) {
  std::unique_ptr<OipEngine> out;
  EXPECT_TRUE(becomes_true(
      [&] {
        out = std::make_unique<OipEngine>(addresses, options);
        return out->error().what.empty();
      },
      [&] { return "a model: " + out->error().message(); }));
  return out;
}

}  // namespace weir::engine_test
