// Element<Impl, Base>: turns a C++ class into a GStreamer element.
//
// Impl declares kInfo, kPads, Settings, kProperties and any virtual function of its Base by name.
// Each callback is a barrier: an Error or exception is posted as an element message, the callback
// returns its failure value, and nothing is thrown into C. Impl may also have
//   void property_changed(const char* name)   after a write, without the settings lock
//   Status check_change(const char* name, const Settings& wanted) const
//                                             before a write while frames may flow: an error is
//                                             posted as a warning, and the old value stays
//   static bool is_followed(const char* name) whether follow_settings() handles this property;
//                                             without it, all but "silent"
//   Ledger ledger_                            shown as the read-only property "stats"
//   BufferLimit buffer_limit_                 shown as the property "max-buffer-size"
//   void add_stats(GstStructure*) const       adds its own fields to "stats"
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <atomic>
#include <cstring>
#include <exception>
#include <memory>
#include <mutex>
#include <new>
#include <tuple>

#include "core/limit/buffer_limit.hpp"
#include "gstcpp/element/documentation.hpp"
#include "gstcpp/element/error.hpp"
#include "gstcpp/element/ledger_stats.hpp"
#include "gstcpp/element/live_settings.hpp"
#include "gstcpp/element/log.hpp"
#include "gstcpp/element/property.hpp"
#include "weir/result.hpp"

namespace weir::gst {

struct ElementInfo {
  const char* type_name;
  const char* factory_name;
  const char* long_name;
  const char* klass;
  const char* description;
};

template <class R>
constexpr R failure() {
  if constexpr (std::is_same_v<R, GstFlowReturn>)
    return GST_FLOW_ERROR;
  else if constexpr (std::is_same_v<R, GstStateChangeReturn>)
    return GST_STATE_CHANGE_FAILURE;
  else
    return R();
}
template <class R>
constexpr R success() {
  if constexpr (std::is_same_v<R, GstFlowReturn>)
    return GST_FLOW_OK;
  else
    return R(TRUE);
}

// Runs f; Status errors and exceptions are posted on `element` and return failure<R>().
template <class R, class F>
R guarded(GstElement* element, F&& f) noexcept {
  try {
    if constexpr (std::is_void_v<R>) {
      f();
    } else if constexpr (std::is_same_v<decltype(f()), Status>) {
      const Status status = f();
      if (status) return success<R>();
      post_error(element, status.error());
    } else {
      return f();
    }
  } catch (const std::bad_alloc&) {
    post_error(element, Error{.code = Code::OUT_OF_MEMORY, .what = "memory ran out"});
  } catch (const std::exception& e) {
    post_error(element, Error{.code = Code::INTERNAL, .what = e.what()});
  } catch (...) {
    post_error(element, Error{.code = Code::INTERNAL, .what = "unknown exception"});
  }
  if constexpr (!std::is_void_v<R>) return failure<R>();
}

template <class Impl, class Base>
class Element {
 public:
  using Parent = typename Base::Instance;
  using ParentClass = typename Base::Class;
  struct Instance {
    Parent parent;
    Impl* impl;  // null only when its constructor failed: every callback then fails
  };
  struct Class {
    ParentClass parent;
  };

  static GType type() {
    static const GType t = g_type_register_static_simple(
        Base::type(), Impl::kInfo.type_name, sizeof(Class), GClassInitFunc(class_init),
        sizeof(Instance), GInstanceInitFunc(init), GTypeFlags(0));
    return t;
  }
  // The debug category with the name of the element's factory.
  static GstDebugCategory* category() {
    static GstDebugCategory* const category =
        debug_category(Impl::kInfo.factory_name, Impl::kInfo.description);
    return category;
  }
  static bool register_in(GstPlugin* plugin) {
    return gst_element_register(plugin, Impl::kInfo.factory_name, GST_RANK_NONE, type());
  }

  static const Ledger* get_ledger(gpointer o) {
    const Impl* impl = of(o);
    return impl ? &impl->ledger_ : nullptr;
  }

  // Points one virtual-function slot to one method of Impl.
  template <auto Method, class R, class Self, class... A>
  static void bind(R (*&slot)(Self*, A...)) {
    slot = [](Self* self, A... args) -> R {
      Impl* impl = of(self);
      return guarded<R>(GST_ELEMENT_CAST(self), [&] { return call<Method>(impl, args...); });
    };
  }
  // Pad functions: the pad's parent is the element.
  template <auto Method>
  static GstFlowReturn chain(GstPad* pad, GstObject* parent, GstBuffer* buffer) {
    log_buffer(pad, buffer);
    return guarded<GstFlowReturn>(GST_ELEMENT_CAST(parent),
                                  [&] { return call<Method>(of(parent), buffer); });
  }
  // The same for elements with different kinds of pads.
  template <auto Method>
  static GstFlowReturn pad_chain(GstPad* pad, GstObject* parent, GstBuffer* buffer) {
    log_buffer(pad, buffer);
    return guarded<GstFlowReturn>(GST_ELEMENT_CAST(parent),
                                  [&] { return call<Method>(of(parent), pad, buffer); });
  }
  template <auto Method>
  static gboolean pad_event(GstPad* pad, GstObject* parent, GstEvent* event) {
    CapsTrial trial(GST_ELEMENT_CAST(parent), event);
    return trial.ended(guarded<gboolean>(GST_ELEMENT_CAST(parent), [&]() -> gboolean {
      return call<Method>(of(parent), pad, event);
    }));
  }
  template <auto Method>
  static gboolean pad_query(GstPad* pad, GstObject* parent, GstQuery* query) {
    return guarded<gboolean>(GST_ELEMENT_CAST(parent),
                             [&]() -> gboolean { return call<Method>(of(parent), pad, query); });
  }

  static void log_buffer(void* object, GstBuffer* buffer) {
    GST_CAT_LOG_OBJECT(category(), object, "%" GST_PTR_FORMAT, static_cast<void*>(buffer));
  }

 protected:
  Parent* self() const { return self_; }
  GstElement* element() const { return GST_ELEMENT_CAST(self_); }
  static ParentClass* parent_class() { return static_cast<ParentClass*>(parent_class_); }
  // A pad of the template of this name; the element owns it.
  GstPad* add_pad(const char* name) {
    GstPad* pad = gst_pad_new_from_template(
        gst_element_class_get_pad_template(GST_ELEMENT_GET_CLASS(element()), name), name);
    gst_element_add_pad(element(), pad);
    return pad;
  }
  // A copy, so that streaming code never holds the lock.
  auto settings() const {
    std::lock_guard lock(settings_mutex_);
    return static_cast<const Impl*>(this)->settings_;
  }
  template <class F>
  void change_settings(F&& f) {
    std::lock_guard lock(settings_mutex_);
    f(static_cast<Impl*>(this)->settings_);
  }

  // Makes the current properties the settings in effect at the start of a stream.
  template <class Settings>
  Settings take_settings(LiveSettings<Settings>* followed) {
    std::lock_guard lock(settings_mutex_);
    is_written_ = false;
    written_.reset();
    *followed = {static_cast<Impl*>(this)->settings_, {}, {}};
    return followed->in_force;
  }
  bool is_written() const noexcept { return is_written_; }  // since the last of these two calls
  // Call between two frames. If properties were written since the last call, `judge` decides
  // whether the stream can continue with them and applies them. Rejected values read back as
  // before, and a warning is posted. True when the settings in effect changed.
  template <class Settings, class Judge>
  bool follow_settings(LiveSettings<Settings>* followed, Judge&& judge) {
    if (!is_written_) return false;
    is_written_ = false;  // before take_written(): a write from here on is judged next time
    const auto [now, written] = take_written();
    if (written.none()) return false;
    const auto whole = followed->joined(Impl::kProperties, now, written);
    if (!followed->differs(Impl::kProperties, whole, counts)) return false;
    Status status = judge(whole);
    const bool alone = !status && followed->waiting.any();
    if (alone) {  // the new values may be valid without those rejected before
      if (!followed->differs(Impl::kProperties, now, counts)) return false;
      status = judge(now);
    }
    {
      std::lock_guard lock(settings_mutex_);
      Settings& shown = static_cast<Impl*>(this)->settings_;
      if (!status)
        followed->refuse(Impl::kProperties, whole, written, &shown, written & ~written_);
      else if (alone)
        followed->in_force = now;
      else
        followed->accept(Impl::kProperties, whole, &shown, ~written_);
    }
    if (!status) post_warning(element(), status.error());
    return status.has_value();
  }

 private:
  static Impl* of(gpointer o) { return static_cast<Instance*>(o)->impl; }

  template <auto Method, class... A>
  static decltype(auto) call(Impl* impl, A... args) {
    if (!impl) throw std::bad_alloc();
    return (impl->*Method)(args...);
  }

  static void init(Instance* o, gpointer) {
    guarded<void>(GST_ELEMENT_CAST(o), [o] {
      auto impl = std::make_unique<Impl>();
      impl->self_ = &o->parent;
      o->impl = impl.get();
      if constexpr (requires { impl->constructed(); }) impl->constructed();
      impl.release();
    });
  }
  static void finalize(GObject* o) {
    const std::unique_ptr<Impl> impl(std::exchange(reinterpret_cast<Instance*>(o)->impl, nullptr));
    G_OBJECT_CLASS(parent_class_)->finalize(o);
  }

  template <class F>
  static void with_property(guint id, F&& f) {
    std::apply(
        [&](const auto&... p) {
          guint i = 0;
          ((++i == id ? f(p) : void()), ...);
        },
        Impl::kProperties);
  }
  static void set_property(GObject* o, guint id, const GValue* v, GParamSpec* spec) {
    Impl* impl = of(o);
    if (!impl) return;
    guarded<void>(GST_ELEMENT_CAST(o), [&] {
      if (id == limit_id()) {
        if constexpr (requires { impl->buffer_limit_; })
          impl->buffer_limit_.set_bytes(g_value_get_uint64(v));
        return;
      }
      if (may_run(o) && !may_change(impl, id, v, spec)) return;
      write(impl, id, v);
      if constexpr (requires { impl->property_changed(""); }) impl->property_changed(spec->name);
    });
  }
  static void write(Impl* impl, guint id, const GValue* v) {
    with_property(id, [&](const auto& p) {
      if constexpr (requires { p.field; }) {
        std::lock_guard lock(impl->settings_mutex_);
        auto& field = impl->settings_.*p.field;
        field = from_gvalue<std::decay_t<decltype(field)>>(v);
        if (!counts(p.name)) return;
        impl->written_.set(id - 1);
        impl->is_written_ = true;
      }
    });
  }
  static bool counts(const char* name) {
    if constexpr (requires { Impl::is_followed(name); })
      return Impl::is_followed(name);
    else
      return std::strcmp(name, "silent") != 0;
  }
  auto take_written() {
    std::lock_guard lock(settings_mutex_);
    return std::pair(static_cast<const Impl*>(this)->settings_, std::exchange(written_, {}));
  }
  static bool may_run(GObject* o) {
    GST_OBJECT_LOCK(o);
    const bool runs = GST_STATE(o) >= GST_STATE_PAUSED;
    GST_OBJECT_UNLOCK(o);
    return runs;
  }
  // For elements that may be processing frames: false, with a warning, if the value cannot be
  // applied.
  static bool may_change(Impl* impl, guint id, const GValue* v, GParamSpec* spec) {
    auto wanted = impl->settings();
    bool same = false;
    with_property(id, [&](const auto& p) {
      if constexpr (requires { p.field; }) {
        auto& field = wanted.*p.field;
        auto value = from_gvalue<std::decay_t<decltype(field)>>(v);
        same = value == field;
        field = std::move(value);
      }
    });
    if (!(spec->flags & GST_PARAM_MUTABLE_PLAYING)) {
      if (!same) post_warning(impl->element(), property_is_fixed(spec->name, v));
      return false;
    }
    if constexpr (requires { impl->check_change("", wanted); })
      if (const Status status = impl->check_change(spec->name, wanted); !status) {
        post_warning(impl->element(), status.error());
        return false;
      }
    return true;
  }
  static void get_property(GObject* o, guint id, GValue* v, GParamSpec*) {
    Impl* impl = of(o);
    if (!impl) return;
    guarded<void>(GST_ELEMENT_CAST(o), [&] {
      if (id == stats_id()) {
        g_value_take_boxed(v, stats(*impl));
        return;
      }
      if (id == limit_id()) {
        if constexpr (requires { impl->buffer_limit_; })
          g_value_set_uint64(v, impl->buffer_limit_.bytes());
        return;
      }
      with_property(id, [&](const auto& p) {
        if constexpr (requires { p.get; }) {
          to_gvalue((impl->*p.get)(), v);
        } else {
          std::lock_guard lock(impl->settings_mutex_);
          to_gvalue(impl->settings_.*p.field, v);
        }
      });
    });
  }
  static constexpr guint stats_id() {
    static_assert(std::tuple_size_v<std::decay_t<decltype(Impl::kProperties)>> <= 64);
    return static_cast<guint>(std::tuple_size_v<std::decay_t<decltype(Impl::kProperties)>> + 1);
  }
  static constexpr guint limit_id() { return stats_id() + 1; }
  static GstStructure* stats(const Impl& impl) {
    GstStructure* structure = to_structure(impl.ledger_.snapshot());
    if constexpr (requires { impl.add_stats(structure); }) impl.add_stats(structure);
    return structure;
  }

  static GstStateChangeReturn on_change_state(GstElement* element, GstStateChange change) {
    if (change == GST_STATE_CHANGE_READY_TO_PAUSED) forget_refusal(element);
    if constexpr (requires { &Impl::change_state; })
      return guarded<GstStateChangeReturn>(
          element, [&] { return call<&Impl::change_state>(of(element), change); });
    else
      return GST_ELEMENT_CLASS(parent_class_)->change_state(element, change);
  }

  static void class_init(Class* k, gpointer) {
    parent_class_ = g_type_class_peek_parent(k);
    set_category(G_TYPE_FROM_CLASS(k), category());
    auto* object = G_OBJECT_CLASS(k);
    object->finalize = finalize;
    object->set_property = set_property;
    object->get_property = get_property;
    std::apply(
        [&](const auto&... p) {
          guint id = 0;
          (g_object_class_install_property(object, ++id, param_spec(p)), ...);
        },
        Impl::kProperties);
    g_object_class_install_property(
        object, stats_id(),
        g_param_spec_boxed(
            "stats", "stats", "Frames received, consumed, dropped by reason, held and pushed",
            GST_TYPE_STRUCTURE, GParamFlags(G_PARAM_READABLE | G_PARAM_STATIC_STRINGS)));
    if constexpr (requires(Impl & impl) { impl.buffer_limit_; })
      g_object_class_install_property(
          object, limit_id(),
          g_param_spec_uint64(
              "max-buffer-size", "max-buffer-size",
              "Largest output buffer in bytes; a larger one is an error before it is allocated; "
              "0 = no limit",
              0, G_MAXUINT64, BufferLimit::kDefaultBytes,
              writable_flags(Changeable::WhilePlaying)));

    auto* element = GST_ELEMENT_CLASS(k);
    gst_element_class_set_static_metadata(element, Impl::kInfo.long_name, Impl::kInfo.klass,
                                          Impl::kInfo.description, "The Weir developers");
    set_documentation_link(element, Impl::kInfo.factory_name);
    if constexpr (requires { Impl::add_pad_templates(element); })
      Impl::add_pad_templates(element);
    else
      for (auto& pad : Impl::kPads) gst_element_class_add_static_pad_template(element, &pad);
    if constexpr (requires { Impl::install_signals(G_TYPE_FROM_CLASS(k)); })
      Impl::install_signals(G_TYPE_FROM_CLASS(k));
    element->change_state = on_change_state;
    if constexpr (requires { &Impl::send_event; }) bind<&Impl::send_event>(element->send_event);
    if constexpr (requires { &Impl::request_new_pad; }) {
      bind<&Impl::request_new_pad>(element->request_new_pad);
      bind<&Impl::release_pad>(element->release_pad);
    }
    Base::template bind_all<Impl>(reinterpret_cast<ParentClass*>(k));
  }

  static inline gpointer parent_class_ = nullptr;
  mutable std::mutex settings_mutex_;  // guards Impl::settings_, written_
  PropertyMask written_;               // since follow_settings() or take_settings()
  std::atomic<bool> is_written_{false};
  Parent* self_ = nullptr;
};

}  // namespace weir::gst
