// SPDX-License-Identifier: LGPL-2.1-or-later
#include "transport/edge/query_listener.hpp"

#include <algorithm>
#include <utility>

#include "core/wire/edge_capability.hpp"

namespace weir::edge {
namespace {

using State = ServedClient::State;

Error refused_client(const std::string& address, const std::string& reason) {
  return Error{.code = Code::PEER_MESSAGE_INVALID,
               .what = "a query client was refused",
               .offered = address + ": " + reason,
               .needed = "a tensor_query_client that speaks the protocol of nnstreamer-edge"};
}

bool is_this_machine(const std::string& address) {
  return address.starts_with("127.");
}

}  // namespace

Result<std::unique_ptr<QueryListener>> QueryListener::open(ListenerOptions options) {
  auto listener = listen_on(options.host, options.port);
  if (!listener) return listener.error();
  std::unique_ptr<QueryListener> out(new QueryListener(std::move(options)));
  out->port_ = get_port(listener->get());
  out->listener_ = *std::move(listener);
  out->start();
  return out;
}

QueryListener::~QueryListener() {
  stop();
}

void QueryListener::stop() {
  set_accepting(false);
  join();
  listener_ = Descriptor();
}

Status QueryListener::set_request_caps(const std::string& caps) {
  return set_caps(&request_caps_, caps);
}
Status QueryListener::set_response_caps(const std::string& caps) {
  return set_caps(&response_caps_, caps);
}
Status QueryListener::expect_response_caps(const std::string& caps) {
  return set_caps(&response_caps_, caps, true);
}

Status QueryListener::set_caps(std::string* caps, const std::string& value, bool is_expected) {
  {
    const std::lock_guard lock(mutex_);
    if (is_expected && !caps->empty()) return ok();
    *caps = value;
    if (request_caps_.empty() || response_caps_.empty()) return ok();
    auto text = wire::query_capability_text({request_caps_, response_caps_});
    if (!text) return text.error();
    const auto form = options_.client.form.value_or(wire::HeaderForm::Bytes2088);
    const auto message = wire::text_message(form, wire::Command::Capability, 0, *text);
    if (!message) return message.error();
    capability_ = *std::move(text);
  }
  wake_->set();
  return ok();
}

void QueryListener::set_accepting(bool accepting) {
  {
    const std::lock_guard lock(mutex_);
    accepting_ = accepting;
    if (!accepting) {
      for (const auto& client : clients_) {
        client->send_errors();
        client->set_gone();
      }
      clients_.clear();
      waiting_.clear();
      changed_.notify_all();
    }
  }
  wake_->set();
}

void QueryListener::close() {
  {
    const std::lock_guard lock(mutex_);
    closed_ = true;
    waiting_.clear();
  }
  wake_->set();
}

std::shared_ptr<Request> QueryListener::take() {
  std::unique_lock lock(mutex_);
  for (;;) {
    changed_.wait(lock, [this] { return interrupted_ || !waiting_.empty(); });
    if (interrupted_) return nullptr;
    auto request = std::move(waiting_.front());
    waiting_.pop_front();
    if (!request->end_if_expired()) return request;
  }
}

QueryListener::Client QueryListener::find(int64_t id) const {
  const auto found = std::find_if(clients_.begin(), clients_.end(),
                                  [&](const auto& client) { return client->id() == id; });
  return found == clients_.end() ? nullptr : *found;
}

QueryListener::Sent QueryListener::respond(int64_t client_id,
                                           const std::vector<std::span<const std::byte>>& memories,
                                           std::shared_ptr<const void> owner,
                                           const std::string& sequence) {
  bool must_wake = false, is_gone = false;
  {
    const std::lock_guard lock(mutex_);
    const auto client = find(client_id);
    if (!client || client->state() != State::Ready) {
      ++answers_lost_;
      return Sent::NoClient;
    }
    const auto queued = client->queue_response(memories, std::move(owner), sequence);
    if (!queued) {
      refuse(client, queued.error().what + ": " + queued.error().offered);
    } else if (*queued) {
      client->send();
    } else {
      ++answers_lost_;
      return Sent::Full;
    }
    is_gone = client->state() == State::Gone;
    must_wake = client->has_responses() || is_gone;
    if (is_gone) ++answers_lost_;
  }
  if (must_wake) wake_->set();
  return is_gone ? Sent::NoClient : Sent::Queued;
}

void QueryListener::refuse(int64_t client_id, const std::string& reason) {
  {
    const std::lock_guard lock(mutex_);
    if (const auto client = find(client_id)) refuse(client, reason);
  }
  wake_->set();
}

bool QueryListener::flush(const io::Deadline& deadline) {
  std::unique_lock lock(mutex_);
  const auto sent = [this] {
    return std::none_of(clients_.begin(), clients_.end(), [](const auto& client) {
      return client->state() != State::Gone && client->has_responses();
    });
  };
  if (deadline) return changed_.wait_until(lock, *deadline, sent);
  changed_.wait(lock, sent);
  return true;
}

ListenerCounts QueryListener::counts() const {
  const std::lock_guard lock(mutex_);
  const auto ready = std::count_if(clients_.begin(), clients_.end(), [](const auto& client) {
    return client->state() == State::Ready;
  });
  return {static_cast<uint32_t>(ready), refused_count_, answers_lost_,
          static_cast<uint32_t>(waiting_.size())};
}

uint32_t QueryListener::count(const std::string& address) const {
  return static_cast<uint32_t>(
      std::count_if(clients_.begin(), clients_.end(), [&](const auto& client) {
        return !client->is_gone() && (address.empty() || client->address() == address);
      }));
}

bool QueryListener::is_full(const std::string& address) const {
  const bool is_limited = address.empty() || !is_this_machine(address);
  const uint32_t max = address.empty() ? options_.max_clients : options_.max_per_address;
  return is_limited && max > 0 && count(address) >= max;
}

// Finds the client that has been silent for longest, before all others one that never asked.
QueryListener::Client QueryListener::silent_client(const std::string& address) const {
  const auto timeout = options_.client.timeout;
  Client out;
  if (timeout.count() == 0) return out;
  for (const auto& client : clients_) {
    const bool is_of_address = address.empty() || client->address() == address;
    const auto since = client->silent_since();
    if (!is_of_address || !since || !io::is_over(io::deadline_in(timeout, 1, *since))) continue;
    const auto rank = [](const Client& of) {
      return std::pair(of->has_sent_a_request(), of->silent_since());
    };
    if (!out || rank(client) < rank(out)) out = client;
  }
  return out;
}

void QueryListener::make_room(const std::string& address) {
  for (const auto& limited : {address, std::string()}) {
    if (!is_full(limited)) continue;
    const auto client = silent_client(limited);
    if (!client) return;  // the one that came is refused
    refuse(client, "it was silent for " + std::to_string(options_.client.timeout.count()) +
                       " ms (property timeout), and another client came");
  }
}

std::string QueryListener::reason_to_refuse(const std::string& address) const {
  if (is_full(""))
    return std::to_string(count("")) + " clients are already connected (property max-connections)";
  if (is_full(address))
    return std::to_string(count(address)) +
           " clients with its address are already connected (property max-connections-per-address)";
  return "";
}

void QueryListener::refuse(const Client& client, const std::string& reason) {
  if (client->is_gone()) return;
  client->send_errors();
  PollServer::refuse(client.get(), refused_client(client->address(), reason));
}

void QueryListener::greet(const Client& client) {
  if (capability_.empty() || client->state() != State::Waiting) return;
  if (const auto status = client->greet(capability_); !status)
    refuse(client, status.error().message());
}

void QueryListener::add(Descriptor socket) {
  int64_t id = new_client_id();
  while (find(id)) id = new_client_id();
  const auto client =
      std::make_shared<ServedClient>(std::move(socket), id, options_.client, requests_, wake_);
  if (options_.allowed && !options_.allowed(client->address()))
    return refuse(client, "the property allow does not contain its address");
  make_room(client->address());
  if (const auto reason = reason_to_refuse(client->address()); !reason.empty())
    return refuse(client, reason);
  clients_.push_back(client);
}

// The oldest client of an address is read even if the bytes of all its clients are too many, so
// that one at least goes on.
bool QueryListener::may_read(const Client& client, bool many_bytes) const {
  if (client->state() == State::Connecting) return false;  // its responses have no way yet
  if (client->state() != State::Ready) return true;
  if (closed_) return false;
  const uint32_t requests = client->load()->requests;
  if (options_.max_requests > 0 && requests >= options_.max_requests) return false;
  if (!many_bytes) return true;
  uint64_t bytes = 0;
  Client oldest;
  for (const auto& other : clients_) {
    if (other->state() != State::Ready || other->address() != client->address()) continue;
    if (!oldest) oldest = other;
    bytes += other->load()->bytes + other->partial_bytes();
  }
  return bytes < options_.max_address_bytes || (oldest == client && requests == 0);
}

io::Deadline QueryListener::watch(const Clients& clients, std::vector<pollfd>* watched) {
  io::Deadline next;
  uint64_t bytes = 0;
  for (const auto& client : clients) bytes += client->load()->bytes + client->partial_bytes();
  const bool many_bytes = options_.max_address_bytes > 0 && bytes >= options_.max_address_bytes;
  bool all_read = true;
  wake_->set_wanted(true);  // before it is decided, so that a request that ends now wakes this
  for (const auto& client : clients) {
    const bool reads = may_read(client, many_bytes);
    all_read = all_read && reads;
    client->watch(reads, watched);
    next = io::earlier(next, client->deadline());
  }
  if (all_read) wake_->set_wanted(false);
  return next;
}

void QueryListener::attend(const Client& client, const pollfd* events, ServedClient::Input input) {
  greet(client);
  std::shared_ptr<Request> request;
  if (const auto reason = client->attend(events, std::move(input), &request))
    return refuse(client, *reason);
  if (request) waiting_.push_back(std::move(request));
  if (!client->is_gone() && io::is_over(client->deadline()))
    refuse(client, client->reason_of_deadline());
}

void QueryListener::end_turn() {
  for (const auto& client : clients_) greet(client);
}

}  // namespace weir::edge
