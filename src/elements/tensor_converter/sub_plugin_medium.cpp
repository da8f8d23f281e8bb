// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_converter/sub_plugin_medium.hpp"

#include "core/infer/module/guarded_call.hpp"
#include "core/subplugin/loader.hpp"

namespace weir {
namespace {

using gst::Ref;
using subplugin::Kind;

Error failed(const std::string& who, const std::string& what, const std::string& offered,
             const std::string& needed) {
  return {.code = Code::CALLBACK_FAILED,
          .what = who + " " + what,
          .offered = offered,
          .needed = needed,
          .fix = "read its log lines: GST_DEBUG=weir*:5"};
}

// The converter's caps; null, with a log line, when it returns none.
Ref<GstCaps> make_caps(const NNStreamerExternalConverter& type) {
  gst::CTensors config;
  const std::string who = std::string("the converter ") + type.name;
  const auto returned =
      infer::call_guarded(who, "return caps", [&] { return type.query_caps(config.get()); });
  if (!returned) {
    subplugin::log_once(who, "its query_caps threw an exception (" + returned.error().offered +
                                 "); the converter is skipped");
    return {};
  }
  auto caps = Ref<GstCaps>::adopt(*returned);
  if (caps && GST_IS_CAPS(caps.get()) && !gst_caps_is_any(caps.get())) return caps;
  subplugin::log_once(
      who, caps
               ? "its query_caps returned ANY or something else than caps; the converter is skipped"
               : "its query_caps returned NULL; the converter is skipped");
  return {};
}

const NNStreamerExternalConverter* converter(const std::string& name) {
  return static_cast<const NNStreamerExternalConverter*>(
      subplugin::table().find(Kind::Converter, name));
}

std::vector<const NNStreamerExternalConverter*> registered_converters() {
  std::vector<const NNStreamerExternalConverter*> out;
  for (const auto& name : subplugin::table().names(Kind::Converter))
    if (const auto* type = converter(name)) out.push_back(type);
  return out;
}

bool takes(const NNStreamerExternalConverter& type, const char* name) {
  if (std::string_view(type.name) == name) return true;
  const auto caps = make_caps(type);
  for (guint i = 0; caps && i < gst_caps_get_size(caps.get()); ++i)
    if (gst_structure_has_name(gst_caps_get_structure(caps.get(), i), name)) return true;
  return false;
}

// A buffer that a converter may keep, release, modify or return: the caller holds two references,
// and the number left afterwards shows which it did.
class LentBuffer {
 public:
  explicit LentBuffer(GstBuffer* from) : buffer_(gst_buffer_copy(from)) { gst_buffer_ref(buffer_); }
  ~LentBuffer() { gst_buffer_unref(buffer_); }
  LentBuffer(const LentBuffer&) = delete;
  LentBuffer& operator=(const LentBuffer&) = delete;
  GstBuffer* get() const noexcept { return buffer_; }
  // Takes ownership of the returned buffer.
  Ref<GstBuffer> take(GstBuffer* result) {
    const int references = GST_MINI_OBJECT_REFCOUNT_VALUE(buffer_);
    if (references > (result == buffer_ ? 2 : 1)) gst_buffer_unref(buffer_);
    return Ref<GstBuffer>::adopt(result);
  }

 private:
  GstBuffer* buffer_;
};

}  // namespace

SubPluginMedium::SubPluginMedium(const NNStreamerExternalConverter& type)
    : name_("the converter " + std::string(type.name)), type_(type) {}

SubPluginMedium::SubPluginMedium(std::string name, tensor_converter_custom function, void* data,
                                 std::shared_ptr<infer::CallGate> gate)
    : name_("the function " + std::move(name)),
      function_(function),
      gate_(std::move(gate)),
      data_(data) {}

SubPluginMedium::~SubPluginMedium() {
  if (opened_ && type_->close) type_->close(&data_);
}

Result<std::unique_ptr<Medium>> SubPluginMedium::open(const NNStreamerExternalConverter& type,
                                                      const std::optional<std::string>& script) {
  std::unique_ptr<SubPluginMedium> medium(new SubPluginMedium(type));
  if (script) {
    if (!type.open)
      return failed(medium->name_, "does not accept a script", *script,
                    "a converter with the function open");
    const auto result = infer::call_guarded(medium->name_, "return a number below 0", [&] {
      return type.open(script->c_str(), &medium->data_);
    });
    if (!result) return result.error();
    if (*result < 0)
      return failed(medium->name_, "cannot open the script",
                    *script + ": open returned " + std::to_string(*result), "0 or more");
    medium->opened_ = true;
  }
  return std::unique_ptr<Medium>(std::move(medium));
}

Result<FrameSpec> SubPluginMedium::first_spec(const GstCaps* caps) const {
  if (!type_) return FrameSpec{Format::Static, {{ElementType::UInt8, Shape{1, 1, 1, 1}, ""}}, {}};
  gst::CTensors config;
  const auto accepted = infer::call_guarded(
      name_, "return FALSE", [&] { return type_->get_out_config(caps, config.get()); });
  if (!accepted) return accepted.error();
  if (!*accepted) {
    const gst::UniqueText text{gst_caps_to_string(caps)};
    return Error{.code = Code::FORMAT_UNSUPPORTED,
                 .what = name_ + " rejects this stream",
                 .offered = text.get(),
                 .needed = "a stream for which its get_out_config returns TRUE"};
  }
  return config.spec(name_);
}

Result<StreamPlan> SubPluginMedium::configure(const GstCaps* caps, const Preferences& preferences) {
  frames_per_tensor_ = preferences.frames_per_tensor;
  user_ = preferences.tensors;
  rate_ = get_rate(caps);
  StreamPlan plan;
  plan.spec.format = Format::Static;
  plan.spec.rate = rate_;
  plan.frames_out = frames_per_tensor_;
  plan.frames_have_rates = true;
  plan.spec.tensors = !user_.empty() ? user_ : preferences.peer;
  if (!plan.spec.tensors.empty()) return plan;
  auto spec = first_spec(caps);
  if (!spec) return spec.error();
  if (auto status = gather(frames_per_tensor_, &spec->tensors); !status) return status.error();
  plan_before_the_first(preferences, &plan);
  if (!spec->tensors.empty()) plan.spec.tensors = std::move(spec->tensors);
  if (spec->rate.valid()) plan.spec.rate = spec->rate;
  return plan;
}

Result<Ref<GstBuffer>> SubPluginMedium::convert(GstBuffer* in, GstTensorsConfig* config) {
  LentBuffer lent(in);
  const auto made = infer::call_guarded(*gate_, name_, "return NULL", [&] {
    return type_ ? type_->convert(lent.get(), config, data_) : function_(lent.get(), data_, config);
  });
  auto taken = lent.take(made ? *made : nullptr);
  if (!made) return made.error();
  return taken;
}

// Moves the tensors out of `spec`.
Result<MediumFrames> SubPluginMedium::read_tensors(Ref<GstBuffer> made, FrameSpec* spec,
                                                   Ledger* ledger) {
  if (spec->format == Format::Flexible) {
    if (frames_per_tensor_ > 1)
      return Error{
          .code = Code::OPTION_VALUE,
          .what = name_ + " outputs flexible tensors, which cannot be combined into one output",
          .offered = "frames-per-tensor=" + std::to_string(frames_per_tensor_),
          .needed = "frames-per-tensor=1",
          .fix = "tensor_converter frames-per-tensor=1"};
    return flexible_.frames(std::move(made), ledger);
  }
  const size_t size = gst_buffer_get_size(made.get());
  if (size != spec->bytes())
    return Error{.code = Code::FRAME_SIZE,
                 .what = name_ + " returned a frame whose size differs from its declared size",
                 .offered = std::to_string(size) + " bytes",
                 .needed = std::to_string(*spec->bytes()) + " bytes for " + spec->to_string(),
                 .fix = "correct its convert"};
  MediumFrames out;
  out.buffer = std::move(made);
  out.tensors = std::move(spec->tensors);
  return out;
}

Result<MediumFrames> SubPluginMedium::frames(Ref<GstBuffer> buffer, Ledger* ledger) {
  gst::CTensors config({Format::Static, {}, rate_});
  auto converted = convert(buffer.get(), config.get());
  if (!converted) return converted.error();
  auto made = *std::move(converted);
  if (!made) return failed(name_, "returned nothing for a frame", "NULL", "a buffer");
  if (!GST_IS_BUFFER(made.get()))
    return failed(name_, "returned no GstBuffer for a frame", "no buffer", "a buffer");
  auto spec = config.spec(name_);
  if (!spec) return spec.error();
  const bool timed = GST_BUFFER_PTS_IS_VALID(made.get());
  if (!timed) {
    made = Ref<GstBuffer>::adopt(gst_buffer_make_writable(made.release()));
    gst_buffer_copy_into(made.get(), buffer.get(),
                         GstBufferCopyFlags(GST_BUFFER_COPY_FLAGS | GST_BUFFER_COPY_TIMESTAMPS), 0,
                         static_cast<gsize>(-1));
  }
  auto read = read_tensors(std::move(made), &*spec, ledger);
  if (!read) return read.error();
  MediumFrames out = *std::move(read);
  if (auto status = gather(frames_per_tensor_, &out.tensors); !status) return status.error();
  if (auto status = agree(out.tensors, user_); !status) return status.error();
  if (spec->rate.valid()) out.rate = spec->rate;
  return out;
}

Result<std::unique_ptr<Medium>> sub_plugin_medium_for(const char* caps_name) {
  subplugin::open_all(Kind::Converter);
  for (const auto* type : registered_converters())
    if (takes(*type, caps_name)) return SubPluginMedium::open(*type);
  return std::unique_ptr<Medium>();
}

Ref<GstCaps> caps_of_sub_plugin_converters() {
  auto all = Ref<GstCaps>::adopt(gst_caps_new_empty());
  for (const auto* type : registered_converters()) {
    if (auto caps = make_caps(*type))
      all = Ref<GstCaps>::adopt(gst_caps_merge(all.release(), caps.release()));
    if (std::string_view(type->name).find('/') != std::string_view::npos)
      all =
          Ref<GstCaps>::adopt(gst_caps_merge(all.release(), gst_caps_new_empty_simple(type->name)));
  }
  return all;
}

}  // namespace weir
