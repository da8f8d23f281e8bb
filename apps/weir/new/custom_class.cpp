// `weir new nnstreamer-filter`: writes a source that exports NNStreamer_custom, and a makefile.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>
#include <array>
#include <cctype>
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "commands.hpp"
#include "core/text/text.hpp"
#include "report.hpp"
#include "weir/result.hpp"

namespace weir::app {
namespace {

namespace fs = std::filesystem;

constexpr size_t kMaxClassName = 64;

constexpr std::string_view kHead =
    R"(/* NAME, a custom filter: tensor_filter framework=custom model=$PWD/FILE.so
 * It gives each frame as it comes; what is yours to write is marked with TODO. */
#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "tensor_filter_custom.h"

struct NAME {
  unsigned long frames; /* TODO: what the filter keeps from frame to frame */
};

/* The custom= string is prop->custom_properties, or NULL. What this returns comes back as priv. */
static void *NAME_init(const GstTensorFilterProperties *prop) {
  (void)prop;
  return calloc(1, sizeof(struct NAME));
}

static void NAME_exit(void *priv, const GstTensorFilterProperties *prop) {
  (void)prop;
  free(priv);
}
)";
constexpr std::string_view kFixed = R"(
/* TODO: how many tensors there are, of which type and dimensions, innermost first. */
static int NAME_sizes(GstTensorsInfo *info) {
  info->num_tensors = 1;
  info->info[0].type = _NNS_UINT8;
  info->info[0].dimension[0] = 3;
  info->info[0].dimension[1] = 224;
  info->info[0].dimension[2] = 224;
  info->info[0].dimension[3] = 1;
  return 0;
}

static int NAME_get_input(void *priv, const GstTensorFilterProperties *prop, GstTensorsInfo *info) {
  (void)priv;
  (void)prop;
  return NAME_sizes(info);
}

static int NAME_get_output(void *priv, const GstTensorFilterProperties *prop, GstTensorsInfo *info) {
  (void)priv;
  (void)prop;
  return NAME_sizes(info);
}
)";
constexpr std::string_view kAnySize = R"(
/* What comes out for inputs of these: below 0 refuses them. TODO: your own outputs. */
static int NAME_set_input(void *priv, const GstTensorFilterProperties *prop, const GstTensorsInfo *in_info,
                          GstTensorsInfo *out_info) {
  unsigned i;
  (void)priv;
  (void)prop;
  if (in_info->num_tensors > NNS_TENSOR_MEMORY_MAX) return -EINVAL;
  out_info->num_tensors = in_info->num_tensors;
  for (i = 0; i < in_info->num_tensors; ++i) {
    out_info->info[i].type = in_info->info[i].type;
    memcpy(out_info->info[i].dimension, in_info->info[i].dimension, sizeof out_info->info[i].dimension);
  }
  return 0;
}
)";
constexpr std::string_view kInvoke = R"(
/* 0: done; below 0: failed; above 0: nothing comes of this frame. */
static int NAME_invoke(void *priv, const GstTensorFilterProperties *prop, const GstTensorMemory *input,
                       GstTensorMemory *output) {
  unsigned i;
  ((struct NAME *)priv)->frames++;
  for (i = 0; i < prop->output_meta.num_tensors; ++i) /* TODO: your own numbers */
    memcpy(output[i].data, input[i].data, output[i].size);
  return 0;
}
)";
constexpr std::string_view kAllocate = R"(
/* Frees what invoke allocated, on any thread. */
static void NAME_destroy(void *data) {
  free(data);
}

/* 0: done; below 0: failed; above 0: nothing comes of this frame. Each output is allocated here. */
static int NAME_invoke(void *priv, const GstTensorFilterProperties *prop, const GstTensorMemory *input,
                       GstTensorMemory *output) {
  unsigned i;
  ((struct NAME *)priv)->frames++;
  for (i = 0; i < prop->output_meta.num_tensors; ++i) { /* TODO: your own numbers */
    output[i].data = malloc(output[i].size);
    if (!output[i].data) return -ENOMEM;
    memcpy(output[i].data, input[i].data, output[i].size);
  }
  return 0;
}
)";
constexpr std::string_view kMake =
    "# make -f FILE.mk\nCFLAGS ?= -O2 -g -Wall -Wextra\n\nFILE.so: FILE.c\n"
    "\t$(CC) $(CFLAGS) -shared -fPIC $(shell pkg-config --cflags nnstreamer) $< -o $@\n";

std::string callbacks(const CustomClassOptions& options) {
  std::string out =
      "\nstatic NNStreamer_custom_class NAME_callbacks = {\n  .initfunc = NAME_init,\n"
      "  .exitfunc = NAME_exit,\n";
  out += options.fixed ? "  .getInputDim = NAME_get_input,\n  .getOutputDim = NAME_get_output,\n"
                       : "  .setInputDim = NAME_set_input,\n";
  out += options.allocates
             ? "  .allocate_invoke = NAME_invoke,\n  .destroy_notify = NAME_destroy,\n"
             : "  .invoke = NAME_invoke,\n";
  return out + "};\n\nNNStreamer_custom_class *NNStreamer_custom = &NAME_callbacks;\n";
}

std::string filled(std::string text, const CustomClassOptions& options, const std::string& file) {
  const std::array<std::pair<std::string_view, std::string>, 2> words{
      {{"NAME", options.name}, {"FILE", file}}};
  std::string out;
  for (size_t at = 0; at < text.size();) {
    const auto word = std::find_if(words.begin(), words.end(), [&](const auto& each) {
      return std::string_view(text).substr(at).starts_with(each.first);
    });
    out += word == words.end() ? text.substr(at, 1) : word->second;
    at += word == words.end() ? 1 : word->first.size();
  }
  return out;
}

Status check_class_name(const std::string& name) {
  const auto plain = [](unsigned char c) { return c < 128 && (std::isalnum(c) || c == '_'); };
  if (!name.empty() && name.size() <= kMaxClassName && !std::isdigit(name[0]) &&
      std::all_of(name.begin(), name.end(), plain))
    return ok();
  return Error{.code = Code::OPTION_VALUE,
               .what = "this cannot be the name of a filter in C",
               .offered = '"' + name + '"',
               .needed = "letters, digits and _, not a digit first, 64 at most",
               .fix = "weir new nnstreamer-filter brightness"};
}

Status check_base(const std::string& base) {
  const auto plain = [](unsigned char c) {
    return c < 128 && (std::isalnum(c) || c == '_' || c == '-' || c == '.');
  };
  if (!base.empty() && base.size() <= kMaxClassName && std::all_of(base.begin(), base.end(), plain))
    return ok();
  return Error{.code = Code::OPTION_VALUE,
               .what = "this cannot be part of a file name",
               .offered = '"' + base + '"',
               .needed = "letters, digits, _, - and dots, 64 at most, no folder",
               .fix = "weir new nnstreamer-filter --base bright brightness"};
}

Status write(const fs::path& path, const std::string& text) {
  std::error_code failed;
  std::string why;
  if (fs::exists(fs::symlink_status(path, failed)))
    why = "it exists already";
  else if (std::ofstream file(path, std::ios::binary); !(file << text) || !file.flush())
    why = "it cannot be written";
  if (why.empty()) return ok();
  return Error{.code = Code::FILE_NOT_WRITTEN,
               .what = "a file of the new filter cannot be written",
               .offered = path.string() + ": " + why,
               .needed = "an unused name, in a writable folder"};
}

}  // namespace

int new_custom_class(const CustomClassOptions& options) {
  const std::string base = options.base.empty() ? options.name : options.base;
  for (const Status& status : {check_class_name(options.name), check_base(base)})
    if (!status) return report(status.error(), false);
  const std::string file = "nnstreamer_customfilter_" + base;
  std::string source(kHead);
  source += options.fixed ? kFixed : kAnySize;
  source += options.allocates ? kAllocate : kInvoke;
  source += callbacks(options);
  if (auto status = write(file + ".c", filled(source, options, file)); !status)
    return report(status.error(), false);
  if (auto status = write(file + ".mk", filled(std::string(kMake), options, file)); !status) {
    std::error_code failed;
    fs::remove(file + ".c", failed);
    return report(status.error(), false);
  }
  std::printf("%s.c\n%s.mk\n\nmake -f %s.mk\n", file.c_str(), file.c_str(), file.c_str());
  return kExitGood;
}

}  // namespace weir::app
