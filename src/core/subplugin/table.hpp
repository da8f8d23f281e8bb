// The registry of sub-plugins for NNStreamer: descriptors by kind and name. Only src/compat
// (filters, registration) and the elements that call them know their layout; core stores the
// pointers.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <map>
#include <mutex>
#include <string>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include "core/infer/module/named_functions.hpp"
#include "core/infer/module/named_objects.hpp"
#include "weir/result.hpp"

namespace weir::subplugin {

enum class Kind { Filter, Decoder, Converter, Trainer };
inline constexpr Kind kKinds[] = {Kind::Filter, Kind::Decoder, Kind::Converter, Kind::Trainer};
const char* to_string(Kind kind) noexcept;  // "filter", as in libnnstreamer_filter_NAME.so

// Thread-safe. Descriptors are borrowed and must stay valid until removed.
class Table {
 public:
  // OPTION_VALUE for an empty, reserved (any, auto, ignoring case) or taken name.
  Status add(Kind kind, std::string_view name, const void* descriptor);
  // Records why a descriptor is unusable, for the error about its file.
  void refuse(Kind kind, const Error& reason);
  // Returns false if the name is unknown. Also removes its descriptions.
  bool remove(Kind kind, std::string_view name);
  const void* find(Kind kind, std::string_view name) const;  // null: none
  std::vector<std::string> names(Kind kind) const;           // sorted

  using Descriptions = std::vector<std::pair<std::string, std::string>>;
  // Describes a custom property of a sub-plugin; the last text of a key is used.
  void describe(Kind kind, const std::string& name, const std::string& key,
                const std::string& text);
  Descriptions descriptions(Kind kind, const std::string& name) const;

  // Records what this thread registers during its lifetime.
  class Recording {
   public:
    explicit Recording(Table& table);
    ~Recording();
    Recording(const Recording&) = delete;
    Recording& operator=(const Recording&) = delete;
    // "it registered the decoder x; the filter y was rejected: ..."; "it registered nothing".
    std::string to_string() const;

   private:
    friend class Table;
    Table& table_;
    Recording* outer_;
    std::vector<std::string> events_;
  };

 private:
  void note(const std::string& event);
  auto& of(Kind kind) { return entries_[static_cast<size_t>(kind)]; }
  const auto& of(Kind kind) const { return entries_[static_cast<size_t>(kind)]; }

  infer::NamedObjects<const void*> entries_[std::size(kKinds)];
  mutable std::mutex mutex_;  // guards the members below
  std::map<std::pair<Kind, std::string>, Descriptions> descriptions_;
  std::map<std::thread::id, Recording*> recordings_;
};

// The table of the process.
Table& table();

// Functions of the application by name; the elements cast them back to their types.
using AnyFunction = void (*)();
using Functions = infer::NamedFunctions<AnyFunction>;
Functions& custom_decoders();    // tensor_decoder_custom
Functions& custom_converters();  // tensor_converter_custom

// OPTION_VALUE for an invalid name.
Status check_name(std::string_view name);

}  // namespace weir::subplugin
