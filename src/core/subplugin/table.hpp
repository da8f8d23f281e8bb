// What sub-plugins for NNStreamer have registered in this process: descriptors by kind and name.
// Their layout is known to src/compat (filters, registration) and to the elements that call them;
// core only keeps the pointers.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <map>
#include <mutex>
#include <string>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include "core/infer/named_functions.hpp"
#include "core/infer/named_objects.hpp"
#include "weir/result.hpp"

namespace weir::subplugin {

enum class Kind { Filter, Decoder, Converter, Trainer };
inline constexpr Kind kKinds[] = {Kind::Filter, Kind::Decoder, Kind::Converter, Kind::Trainer};
const char* name_of(Kind kind) noexcept;  // "filter", as in libnnstreamer_filter_NAME.so

// Thread-safe. Descriptors are borrowed: they stay until they are removed.
class Table {
 public:
  // OPTION_VALUE for a name that is empty, reserved (any, auto, in any case) or taken.
  Status add(Kind kind, std::string_view name, const void* descriptor);
  // Notes that a descriptor cannot be used, for the error of who loads the file.
  void refuse(Kind kind, const Error& reason);
  // False: there is none of this name. Its descriptions go with it.
  bool remove(Kind kind, std::string_view name);
  const void* find(Kind kind, std::string_view name) const;  // null: none
  std::vector<std::string> names(Kind kind) const;           // sorted

  using Descriptions = std::vector<std::pair<std::string, std::string>>;
  // What a custom property does, told by the sub-plugin; a key's last text counts.
  void describe(Kind kind, const std::string& name, const std::string& key,
                const std::string& text);
  Descriptions descriptions(Kind kind, const std::string& name) const;

  // What this thread registers while it lives, in words.
  class Recording {
   public:
    explicit Recording(Table& table);
    ~Recording();
    Recording(const Recording&) = delete;
    Recording& operator=(const Recording&) = delete;
    // "it registered the decoder x; the filter y was refused: ..."; "it registered nothing".
    std::string words() const;

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
  mutable std::mutex mutex_;  // guards what follows
  std::map<std::pair<Kind, std::string>, Descriptions> descriptions_;
  std::map<std::thread::id, Recording*> recordings_;
};

// The process's.
Table& table();

// Functions of a program under a name; the elements know their types and cast them back.
using AnyFunction = void (*)();
using Functions = infer::NamedFunctions<AnyFunction>;
Functions& custom_decoders();    // tensor_decoder_custom
Functions& custom_converters();  // tensor_converter_custom

// OPTION_VALUE for a name that nothing may have.
Status check_name(std::string_view name);

}  // namespace weir::subplugin
