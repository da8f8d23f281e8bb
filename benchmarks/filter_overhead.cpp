// appsrc ! tensor_filter ! fakesink against ONNX Runtime in a bare loop: the same model, the same
// settings, memory made once. Interleaved blocks of frames in one process.
#include <dlfcn.h>
#include <gst/app/gstappsrc.h>
#include <gst/gst.h>
#include <onnxruntime_c_api.h>

#include <condition_variable>
#include <cstring>
#include <memory>
#include <mutex>
#include <stdexcept>

#include "gstcpp/ref.hpp"
#include "rounds.hpp"

namespace {

using weir::gst::Ref;

// One session, one input and one output tensor that are used again for each frame.
class BareLoop {
 public:
  BareLoop(const char* library, const char* model, int threads) {
    void* handle = dlopen(library, RTLD_NOW);
    if (!handle) throw std::runtime_error(dlerror());
    const auto base = reinterpret_cast<const OrtApiBase* (*)()>(dlsym(handle, "OrtGetApiBase"));
    api_ = base()->GetApi(ORT_API_VERSION);
    if (!api_) throw std::runtime_error("the library is older than its header");
    check(api_->CreateEnv(ORT_LOGGING_LEVEL_ERROR, "bare", &env_));
    OrtSessionOptions* options = nullptr;
    check(api_->CreateSessionOptions(&options));
    check(api_->SetIntraOpNumThreads(options, threads));
    check(api_->AddSessionConfigEntry(options, "session.intra_op.allow_spinning", "0"));
    check(api_->CreateSession(env_, model, options, &session_));
    api_->ReleaseSessionOptions(options);
    check(api_->GetAllocatorWithDefaultOptions(&allocator_));
    check(api_->SessionGetInputName(session_, 0, allocator_, &input_name_));
    check(api_->SessionGetOutputName(session_, 0, allocator_, &output_name_));
    input_ = tensor(true);
    output_ = tensor(false);
  }

  void run(int frames) {
    const OrtValue* in = input_;
    for (int i = 0; i < frames; ++i)
      check(api_->Run(session_, nullptr, &input_name_, &in, 1, &output_name_, 1, &output_));
  }
  // The input as caps: innermost dimension first.
  std::string caps() const {
    std::string dimension;
    for (auto at = shape_.rbegin(); at != shape_.rend(); ++at)
      dimension += (dimension.empty() ? "" : ":") + std::to_string(*at);
    return "other/tensor,type=float32,framerate=30/1,dimension=(string)" + dimension;
  }
  size_t input_bytes() const { return bytes_; }

 private:
  void check(OrtStatus* status) const {
    if (status) throw std::runtime_error(api_->GetErrorMessage(status));
  }
  OrtValue* tensor(bool input) {
    OrtTypeInfo* type = nullptr;
    check(input ? api_->SessionGetInputTypeInfo(session_, 0, &type)
                : api_->SessionGetOutputTypeInfo(session_, 0, &type));
    const OrtTensorTypeAndShapeInfo* info = nullptr;
    check(api_->CastTypeInfoToTensorInfo(type, &info));
    size_t rank = 0;
    check(api_->GetDimensionsCount(info, &rank));
    std::vector<int64_t> shape(rank);
    check(api_->GetDimensions(info, shape.data(), rank));
    api_->ReleaseTypeInfo(type);
    OrtValue* value = nullptr;
    check(api_->CreateTensorAsOrtValue(allocator_, shape.data(), rank,
                                       ONNX_TENSOR_ELEMENT_DATA_TYPE_FLOAT, &value));
    size_t bytes = sizeof(float);
    for (const int64_t extent : shape) bytes *= static_cast<size_t>(extent);
    void* data = nullptr;
    check(api_->GetTensorMutableData(value, &data));
    std::memset(data, 0, bytes);
    if (input) shape_ = shape, bytes_ = bytes;
    return value;
  }

  const OrtApi* api_ = nullptr;
  OrtEnv* env_ = nullptr;
  OrtSession* session_ = nullptr;
  OrtAllocator* allocator_ = nullptr;
  char *input_name_ = nullptr, *output_name_ = nullptr;
  OrtValue *input_ = nullptr, *output_ = nullptr;
  std::vector<int64_t> shape_;
  size_t bytes_ = 0;
};

class Pipeline {
 public:
  Pipeline(const BareLoop& bare, const std::string& model, int threads) {
    const std::string launch = "appsrc name=in format=time block=true max-buffers=64 caps=\"" +
                               bare.caps() + "\" ! tensor_filter model=" + model +
                               " custom=NumThreads:" + std::to_string(threads) +
                               " ! fakesink name=out async=false signal-handoffs=true";
    pipeline_ = Ref<GstElement>::adopt(
        GST_ELEMENT(gst_object_ref_sink(gst_parse_launch(launch.c_str(), nullptr))));
    in_ = Ref<GstElement>::adopt(gst_bin_get_by_name(GST_BIN(pipeline_.get()), "in"));
    const auto out = Ref<GstElement>::adopt(gst_bin_get_by_name(GST_BIN(pipeline_.get()), "out"));
    g_signal_connect(out.get(), "handoff", G_CALLBACK(on_frame), this);
    buffer_ = Ref<GstBuffer>::adopt(gst_buffer_new_allocate(nullptr, bare.input_bytes(), nullptr));
    gst_buffer_memset(buffer_.get(), 0, 0, bare.input_bytes());
    gst_element_set_state(pipeline_.get(), GST_STATE_PLAYING);
  }
  ~Pipeline() { gst_element_set_state(pipeline_.get(), GST_STATE_NULL); }
  void run(int frames) {
    wanted_ = frames;
    for (int i = 0; i < frames; ++i)
      gst_app_src_push_buffer(GST_APP_SRC(in_.get()), gst_buffer_copy(buffer_.get()));
    std::unique_lock lock(mutex_);
    done_.wait(lock, [this] { return wanted_ == 0; });
  }

 private:
  static void on_frame(GstElement*, GstBuffer*, GstPad*, Pipeline* self) {
    std::lock_guard lock(self->mutex_);
    if (--self->wanted_ == 0) self->done_.notify_one();
  }
  Ref<GstElement> pipeline_, in_;
  Ref<GstBuffer> buffer_;
  std::mutex mutex_;
  std::condition_variable done_;
  int wanted_ = 0;  // guarded by mutex_ while frames are under way
};

}  // namespace

// filter_overhead LIBRARY MODEL NAME FRAMES ROUNDS AT_MOST_US
int main(int argc, char** argv) {
  gst_init(&argc, &argv);
  if (argc != 7) return 2;
  constexpr int kThreads = 1;
  const int frames = std::atoi(argv[4]), rounds = std::atoi(argv[5]);
  BareLoop bare(argv[1], argv[2], kThreads);
  Pipeline pipeline(bare, argv[2], kThreads);
  const auto costs =
      weir::bench::medians({[&] { bare.run(frames); }, [&] { pipeline.run(frames); }}, rounds);
  const std::string name = std::string("tensor_filter, ") + argv[3];
  const double most = std::atof(argv[6]);
  const std::string floor =
      "bare loop, " + std::to_string(static_cast<int>(costs[0].wall / frames * 1e6)) + " us";
  weir::bench::report(name + ": wall above it", floor,
                      (costs[1].wall - costs[0].wall) / frames * 1e6, "us", most);
  weir::bench::report(name + ": CPU of all threads above it", floor,
                      (costs[1].cpu - costs[0].cpu) / frames * 1e6, "us", most);
}
