#include "remote_cache.h"

#include <algorithm>
#include <limits>
#include <memory>
#include <string_view>
#include <utility>

#include "atomic_file.h"
#include "bake_cache.h"
#include "cache_listing.h"
#include "text_bytes.h"

namespace coppice::bake {
namespace {

constexpr std::size_t kMostConnections = 16;
// Few: each holds an entry in memory, and an upload takes nobody's time.
constexpr std::size_t kMostSending = 4;
constexpr double kSendStall_s = 5.0;
constexpr double kNever_s = std::numeric_limits<double>::infinity();
constexpr std::uint64_t kSendStallBytes = 64'000;
constexpr std::uint64_t kMostIndexBytes = std::uint64_t{256} << 20;  // of two million entries

/// Asking again would be answered the same.
bool is_final(int status) {
  return (status >= 300 && status < 400) || status == 401 || status == 403 || status == 405 || status == 407 || status == 409 ||
         status == 507;
}

}  // namespace

RemoteCache::RemoteCache(RemoteCacheOptions options)
    : options_(std::move(options)),
      transfers_(options_.credentials, kMostConnections),
      reading_(options_.job_count),
      writing_(options_.job_count) {
  report_.where = options_.url;
  ask_index();
}

void RemoteCache::start(HttpRequest request, HttpTransfers::Done done) {
  ++report_.requests;
  transfers_.start(std::move(request), std::move(done));
}

void RemoteCache::went_wrong(CacheBreaker& breaker, const HttpAnswer& answer) {
  using Setback = CacheBreaker::Setback;
  const bool is_dead = answer.trouble == HttpTrouble::unreachable || answer.trouble == HttpTrouble::too_slow;
  const std::string why = answer.trouble == HttpTrouble::none ? status_text(answer.status) : answer.why;
  breaker.went_wrong(is_dead || is_final(answer.status) ? Setback::grave : Setback::odd, why);
  if (is_dead && &breaker == &reading_) writing_.went_wrong(Setback::grave, why);
}

void RemoteCache::ask_index() {
  start({.method = HttpMethod::get, .url = index_url(options_.url), .most_bytes = kMostIndexBytes},
        [this](const HttpAnswer& answer) { read_index_answer(answer); });
}

void RemoteCache::read_index_answer(const HttpAnswer& answer) {
  index_is_pending_ = false;
  const bool whole = answer.trouble == HttpTrouble::none;
  if (whole && is_success(answer.status)) {
    auto index = read_index(as_text(answer.body));
    index_is_missing_ = !index;
    if (index)
      index_ = *std::move(index);
    else
      report_.trouble = index.error().message();
  } else if (whole && is_absent(answer.status)) {
    index_is_missing_ = true;
  } else {
    went_wrong(reading_, answer);
  }
  close_if_open();
  std::vector<std::string> keys;
  for (const auto& [key, wanted] : wanted_) keys.push_back(key);
  for (const std::string& key : keys) look_for(key);
}

double RemoteCache::Wanted::waited_s() const {
  return std::chrono::duration<double>(Clock::now() - since).count();
}

/// The time that goes for nothing as things are: all of it before the first byte, and where what comes would take longer than it is worth.
double RemoteCache::Wanted::at_stake_s() const {
  const double waited = waited_s();
  const double whole = bytes > 0 && of > 0 ? waited * static_cast<double>(of) / static_cast<double>(bytes) : kNever_s;
  return whole > worth.seconds ? waited : 0.0;
}

void RemoteCache::fetch(const std::string& key, const EntryWorth& worth, Done done) {
  const auto [at, is_new] = wanted_.try_emplace(key);
  Wanted& wanted = at->second;
  wanted.worth = {std::max(wanted.worth.seconds, worth.seconds), std::max(wanted.worth.most_bytes, worth.most_bytes)};
  wanted.done.push_back(std::move(done));
  if (reading_.is_open())
    close_if_open();
  else if (is_new && !index_is_pending_)
    look_for(key);
}

void RemoteCache::fetch_record(const std::string& name, Done done) {
  const auto [at, is_new] = wanted_records_.try_emplace(name);
  at->second.done.push_back(std::move(done));
  if (reading_.is_open())
    close_if_open();
  else if (is_new)
    get(record_url(options_.url, name), kMostRecordBytes, wanted_records_, name,
        [this, name](const HttpAnswer& answer) { read_record_answer(name, answer); });
}

void RemoteCache::look_for(const std::string& key) {
  if (!options_.only_indexed || index_.contains(key)) {
    get(entry_url(options_.url, key), wanted_.at(key).worth.most_bytes, wanted_, key,
        [this, key](const HttpAnswer& answer) { read_entry_answer(key, answer); });
    return;
  }
  ++report_.lacking;
  answer_wanted(wanted_, key, {});
}

void RemoteCache::get(const std::string& url, std::uint64_t most_bytes, WantedByName& wanted, const std::string& name,
                      HttpTransfers::Done done) {
  const auto progress = [&wanted, name](std::uint64_t bytes, std::uint64_t of) {
    if (const auto found = wanted.find(name); found != wanted.end()) found->second.bytes = bytes, found->second.of = of;
  };
  start({.method = HttpMethod::get, .url = url, .most_bytes = most_bytes, .progress = progress}, std::move(done));
}

void RemoteCache::read_entry_answer(const std::string& key, const HttpAnswer& answer) {
  const bool whole = answer.trouble == HttpTrouble::none, is_there = whole && is_success(answer.status);
  const auto wanted = wanted_.find(key);
  const double waited_s = wanted == wanted_.end() ? 0.0 : wanted->second.waited_s();
  if (is_there || (whole && is_absent(answer.status))) reading_.went_well();
  if (is_there || answer.trouble == HttpTrouble::too_large) {
    ++report_.found;
    fetched_s_[key] = waited_s;
    if (!index_.contains(key)) added_[key] = answer.body.size();
    answer_wanted(wanted_, key, answer.body);
    if (answer.body.empty()) found_damaged(key);  // or too large for one: to whoever asked it is not there
    return;
  }
  reading_.lost(waited_s);
  if (whole && is_absent(answer.status)) {
    ++report_.lacking;
    gone_.insert(key);
  } else {
    went_wrong(reading_, answer);
    report_.unasked += wanted != wanted_.end() ? 1u : 0u;
  }
  answer_wanted(wanted_, key, {});
  close_if_open();
}

void RemoteCache::read_record_answer(const std::string& name, const HttpAnswer& answer) {
  const bool whole = answer.trouble == HttpTrouble::none, is_there = whole && is_success(answer.status);
  const auto wanted = wanted_records_.find(name);
  if (!is_there && wanted != wanted_records_.end()) reading_.lost(wanted->second.waited_s());
  if (!is_there && !(whole && is_absent(answer.status))) went_wrong(reading_, answer);
  answer_wanted(wanted_records_, name, is_there ? answer.body : std::vector<std::uint8_t>());
  close_if_open();
}

void RemoteCache::answer_wanted(WantedByName& wanted, const std::string& name, const std::vector<std::uint8_t>& bytes) {
  const auto found = wanted.find(name);
  if (found == wanted.end()) return;  // nobody waits any more
  const Wanted answered = std::move(found->second);
  wanted.erase(found);
  for (const Done& done : answered.done) done(bytes);
}

void RemoteCache::let_go(WantedByName& wanted) {
  for (const auto& [name, waiting] : std::exchange(wanted, {})) {
    reading_.lost(waiting.waited_s());
    for (const Done& done : waiting.done) done({});
  }
}

/// Lets go whoever waits for a cache that is no longer asked.
void RemoteCache::close_if_open() {
  if (!reading_.is_open()) return;
  report_.unasked += wanted_.size();
  let_go(wanted_);
  let_go(wanted_records_);
}

void RemoteCache::found_damaged(const std::string& key) {
  constexpr std::uint64_t kFew = 3;
  if (!damaged_.insert(key).second) return;  // several plants may have one key
  ++report_.damaged;
  --report_.found;
  gone_.insert(key);
  added_.erase(key);
  reading_.lost(fetched_s_[key]);
  // Where most are, the rest is not worth a download.
  if (report_.damaged >= kFew && report_.damaged >= report_.found)
    reading_.went_wrong(CacheBreaker::Setback::grave, "most of its entries are damaged");
  close_if_open();
}

void RemoteCache::offer(const std::string& key) {
  if (options_.mode != CacheMode::read_write || !offered_before_.insert(key).second) return;
  offered_.push_back(key);
}

void RemoteCache::send_next() {
  while (!offered_.empty() && !index_is_pending_ && (writing_.is_open() || sending_ < kMostSending)) {
    const std::string key = std::exchange(offered_.front(), {});
    offered_.pop_front();
    if (index_.contains(key) && !gone_.contains(key)) continue;
    if (writing_.is_open())
      ++report_.unsent;
    else
      send(key);
  }
}

void RemoteCache::send(const std::string& key) {
  ++sending_;
  if (damaged_.contains(key)) {  // it is there, and to be replaced
    put(key);
    return;
  }
  start({.method = HttpMethod::head, .url = entry_url(options_.url, key)}, [this, key](const HttpAnswer& answer) {
    if (answer.trouble == HttpTrouble::none && is_absent(answer.status)) {
      put(key);
      return;
    }
    --sending_;
    if (answer.trouble == HttpTrouble::none && is_success(answer.status)) {
      added_[key] = answer.content_bytes;
      return;
    }
    ++report_.unsent;
    went_wrong(writing_, answer);
  });
}

void RemoteCache::put(const std::string& key) {
  const auto entry = peek_cached(options_.folder, key);
  if (!entry) {  // taken away or damaged meanwhile
    --sending_;
    ++report_.unsent;
    return;
  }
  HttpRequest request{.method = HttpMethod::put,
                      .url = entry_url(options_.url, key),
                      .body = bundle_of(*entry),
                      .stall_seconds = kSendStall_s,
                      .stall_bytes = kSendStallBytes};
  const std::uint64_t bytes = request.body.size();
  start(std::move(request), [this, key, bytes](const HttpAnswer& answer) { sent(key, bytes, answer); });
}

void RemoteCache::sent(const std::string& key, std::uint64_t bytes, const HttpAnswer& answer) {
  --sending_;
  if (answer.trouble == HttpTrouble::none && is_success(answer.status)) {
    writing_.went_well();
    ++report_.sent;
    added_[key] = bytes;
    put_record(key);
    return;
  }
  ++report_.unsent;
  went_wrong(writing_, answer);
}

/// For explanations alone: nothing is lost where it fails.
void RemoteCache::put_record(const std::string& key) {
  auto record = read_file(record_file(options_.folder, key));
  const std::vector<KeyPart> parts = record ? parts_of_record(*record) : std::vector<KeyPart>();
  if (parts.empty()) return;
  ++explaining_;
  start({.method = HttpMethod::put, .url = record_url(options_.url, name_digits(parts)), .body = *std::move(record)},
        [this](const HttpAnswer&) { --explaining_; });
}

void RemoteCache::step(double seconds, int also) {
  send_next();
  transfers_.step(seconds, also);
  look_at_waiting();
}

void RemoteCache::look_at_waiting() {
  double seconds = 0.0;
  for (const WantedByName* all : {&wanted_, &wanted_records_})
    for (const auto& [name, wanted] : *all) seconds += wanted.at_stake_s();
  reading_.waiting(seconds);
  if (reading_.is_open() && !(wanted_.empty() && wanted_records_.empty())) {
    writing_.went_wrong(CacheBreaker::Setback::grave, reading_.why());
    close_if_open();
  }
}

HttpAnswer RemoteCache::ask(HttpRequest request, Clock::time_point until) {
  // The answer may come when nobody waits for it any more.
  const auto answer = std::make_shared<HttpAnswer>();
  const auto is_done = std::make_shared<bool>(false);
  start(std::move(request), [answer, is_done](HttpAnswer got) {
    *answer = std::move(got);
    *is_done = true;
  });
  while (!*is_done && Clock::now() < until) transfers_.step(0.05);
  if (!*is_done) return HttpAnswer{.trouble = HttpTrouble::too_slow, .why = "it is slow"};
  return *answer;
}

/// Of the index that is there now, which others may have written, with what this batch found out.
void RemoteCache::write_index(Clock::time_point until) {
  const HttpAnswer now = ask({.method = HttpMethod::get, .url = index_url(options_.url), .most_bytes = kMostIndexBytes}, until);
  auto index = now.status == 200 ? read_index(as_text(now.body)) : Result<CacheIndex>(Error{Status::io, "none"});
  if (!index && now.trouble == HttpTrouble::none) {
    const Clock::time_point half = Clock::now() + (until - Clock::now()) / 2;
    const auto listed = list_cache([&](HttpRequest request) { return ask(std::move(request), half); }, options_.url);
    index = CacheIndex();
    // A server that lists nothing has an index all the same: of what was sent and found since.
    if (listed)
      for (const ListedEntry& entry : *listed) index->emplace(entry.key, entry.bytes);
  }
  if (!index) return;
  for (const std::string& key : gone_) index->erase(key);
  for (const auto& [key, bytes] : added_) index->insert_or_assign(key, bytes);
  const std::string text = index_text(*index);
  HttpRequest request{.method = HttpMethod::put, .url = index_url(options_.url)};
  request.body.assign(text.begin(), text.end());
  const HttpAnswer answer = ask(std::move(request), until);
  if (answer.trouble != HttpTrouble::none || !is_success(answer.status)) went_wrong(writing_, answer);
}

void RemoteCache::finish() {
  const auto left_time = std::chrono::duration<double>(reading_.seconds_left());
  const Clock::time_point until = Clock::now() + std::chrono::duration_cast<Clock::duration>(left_time);
  close_if_open();
  while ((!offered_.empty() || sending_ > 0) && Clock::now() < until) step(0.05, -1);
  const std::size_t left = offered_.size() + sending_;
  if (left > 0) {
    report_.unsent += left;
    writing_.went_wrong(CacheBreaker::Setback::grave, "it is slow: the batch was done before all was sent");
  }
  const bool has_news =
      !added_.empty() || index_is_missing_ || std::ranges::any_of(gone_, [this](const std::string& key) { return index_.contains(key); });
  if (options_.mode == CacheMode::read_write && has_news && !writing_.is_open()) write_index(until);
  while (explaining_ > 0 && !writing_.is_open() && Clock::now() < until) step(0.05, -1);
}

CacheReport RemoteCache::report() const {
  CacheReport report = report_;
  report.lost_seconds = reading_.seconds_lost();
  report.gave_up = reading_.is_open();
  for (const std::string* why : {&reading_.why(), &writing_.why()}) {
    if (why->empty() || report.trouble.find(*why) != std::string::npos) continue;
    report.trouble += (report.trouble.empty() ? "" : "; ") + *why;
  }
  return report;
}

}  // namespace coppice::bake
