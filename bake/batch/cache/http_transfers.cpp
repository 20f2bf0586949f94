#include "http_transfers.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstring>
#include <map>
#include <new>
#include <utility>

#include "curl_functions.h"
#include "printable.h"

namespace coppice::bake {
namespace {

const CurlFunctions& curl() {
  static const CurlFunctions& loaded = **load_curl();
  return loaded;
}

}  // namespace

struct HttpTransfers::Transfer {
  HttpRequest request;
  Done done;
  CURL* easy = nullptr;
  HttpAnswer answer;
  std::size_t sent = 0;  ///< of the request's body
  bool too_large = false;
  Clock::time_point mark;        ///< since when it has moved less than stall_bytes
  std::uint64_t mark_bytes = 0;  ///< moved until then
  std::array<char, CURL_ERROR_SIZE> error{};

  [[nodiscard]] std::uint64_t moved() const { return sent + answer.body.size(); }
  /// Of the answer, as its head says; 0: it does not.
  [[nodiscard]] std::uint64_t content_bytes() const {
    curl_off_t bytes = 0;
    static_cast<void>(curl().easy_getinfo(easy, CURLINFO_CONTENT_LENGTH_DOWNLOAD_T, &bytes));
    return bytes > 0 ? static_cast<std::uint64_t>(bytes) : 0;
  }
};

namespace {

/// A process is set up once. What libcurl frees at its end the system does too.
void initialise() {
  static const CURLcode done = curl().global_init(CURL_GLOBAL_DEFAULT);
  if (done != CURLE_OK) throw std::bad_alloc();
}

template <class T>
void set(CURL* easy, CURLoption option, T value) {
  if (curl().easy_setopt(easy, option, value) == CURLE_OUT_OF_MEMORY) throw std::bad_alloc();
}

HttpTrouble trouble_of(CURLcode code) {
  switch (code) {
    case CURLE_OK:
      return HttpTrouble::none;
    case CURLE_PARTIAL_FILE:
    case CURLE_GOT_NOTHING:
    case CURLE_RECV_ERROR:
    case CURLE_SEND_ERROR:
    case CURLE_BAD_CONTENT_ENCODING:
    case CURLE_WEIRD_SERVER_REPLY:
    case CURLE_UNSUPPORTED_PROTOCOL:
      return HttpTrouble::cut_short;
    case CURLE_OPERATION_TIMEDOUT:
      return HttpTrouble::too_slow;
    default:
      return HttpTrouble::unreachable;
  }
}

}  // namespace

Result<void> load_http() {
  const auto curl = load_curl();
  return curl ? Result<void>() : curl.error();
}

HttpTransfers::HttpTransfers(CacheCredentials credentials, std::size_t at_a_time)
    : credentials_(std::move(credentials)), at_a_time_(at_a_time) {
  initialise();
  multi_ = curl().multi_init();
  if (multi_ == nullptr) throw std::bad_alloc();
  static_cast<void>(curl().multi_setopt(static_cast<CURLM*>(multi_), CURLMOPT_MAXCONNECTS, static_cast<long>(at_a_time)));
  // A server that does not know of it would be waited for.
  curl_slist* headers = curl().slist_append(nullptr, "Expect:");
  if (!credentials_.token.empty()) headers = curl().slist_append(headers, ("Authorization: Bearer " + credentials_.token).c_str());
  headers_ = headers;
}

HttpTransfers::~HttpTransfers() {
  for (const auto& transfer : running_) {
    curl().multi_remove_handle(static_cast<CURLM*>(multi_), transfer->easy);
    curl().easy_cleanup(transfer->easy);
  }
  curl().multi_cleanup(static_cast<CURLM*>(multi_));
  curl().slist_free_all(static_cast<curl_slist*>(headers_));
}

void HttpTransfers::start(HttpRequest request, Done done) {
  auto transfer = std::make_unique<Transfer>();
  transfer->request = std::move(request);
  transfer->done = std::move(done);
  waiting_.push_back(std::move(transfer));
}

void HttpTransfers::begin(std::unique_ptr<Transfer> transfer) {
  CURL* easy = curl().easy_init();
  if (easy == nullptr) throw std::bad_alloc();
  transfer->easy = easy;
  transfer->mark = Clock::now();
  Transfer* self = transfer.get();
  set(easy, CURLOPT_URL, self->request.url.c_str());
  set(easy, CURLOPT_PRIVATE, self);
  set(easy, CURLOPT_ERRORBUFFER, self->error.data());
  set(easy, CURLOPT_NOSIGNAL, 1L);
  set(easy, CURLOPT_QUICK_EXIT, 1L);  // a name that is being looked up is not waited for
  set(easy, CURLOPT_PROTOCOLS_STR, "http,https");
  set(easy, CURLOPT_HTTPHEADER, static_cast<curl_slist*>(headers_));
  set(easy, CURLOPT_USERAGENT, "coppice");
  if (credentials_.token.empty() && credentials_.user.empty()) set(easy, CURLOPT_NETRC, static_cast<long>(CURL_NETRC_OPTIONAL));
  if (!credentials_.user.empty()) {
    set(easy, CURLOPT_USERNAME, credentials_.user.c_str());
    set(easy, CURLOPT_PASSWORD, credentials_.password.c_str());
  }
  using Callback = std::size_t (*)(char*, std::size_t, std::size_t, void*);
  const Callback receive = [](char* data, std::size_t size, std::size_t count, void* user) -> std::size_t {
    Transfer& to = *static_cast<Transfer*>(user);
    const std::size_t bytes = size * count;
    to.too_large = std::max<std::uint64_t>(to.answer.body.size() + bytes, to.content_bytes()) > to.request.most_bytes;
    if (to.too_large) return 0;
    to.answer.body.insert(to.answer.body.end(), data, data + bytes);
    if (to.request.progress) to.request.progress(to.answer.body.size(), to.content_bytes());
    return bytes;
  };
  set(easy, CURLOPT_WRITEFUNCTION, receive);
  set(easy, CURLOPT_WRITEDATA, self);
  if (self->request.method == HttpMethod::head) set(easy, CURLOPT_NOBODY, 1L);
  if (self->request.method == HttpMethod::remove) set(easy, CURLOPT_CUSTOMREQUEST, "DELETE");
  if (self->request.method == HttpMethod::put) {
    const Callback give = [](char* data, std::size_t size, std::size_t count, void* user) -> std::size_t {
      Transfer& from = *static_cast<Transfer*>(user);
      const std::size_t bytes = std::min(size * count, from.request.body.size() - from.sent);
      if (bytes > 0) std::memcpy(data, from.request.body.data() + from.sent, bytes);
      from.sent += bytes;
      return bytes;
    };
    using Seek = int (*)(void*, curl_off_t, int);
    const Seek seek = [](void* user, curl_off_t offset, int origin) -> int {
      Transfer& from = *static_cast<Transfer*>(user);
      if (origin != SEEK_SET || offset < 0 || static_cast<std::uint64_t>(offset) > from.request.body.size()) return CURL_SEEKFUNC_FAIL;
      from.sent = static_cast<std::size_t>(offset);
      return CURL_SEEKFUNC_OK;
    };
    set(easy, CURLOPT_UPLOAD, 1L);
    set(easy, CURLOPT_READFUNCTION, give);
    set(easy, CURLOPT_READDATA, self);
    set(easy, CURLOPT_SEEKFUNCTION, seek);
    set(easy, CURLOPT_SEEKDATA, self);
    set(easy, CURLOPT_INFILESIZE_LARGE, static_cast<curl_off_t>(self->request.body.size()));
  }
  running_.push_back(std::move(transfer));
  if (curl().multi_add_handle(static_cast<CURLM*>(multi_), easy) != CURLM_OK) throw std::bad_alloc();
}

void HttpTransfers::step(double seconds, int also) {
  while (!waiting_.empty() && running_.size() < at_a_time_) {
    std::unique_ptr<Transfer> next = std::move(waiting_.front());
    waiting_.pop_front();
    begin(std::move(next));
  }
  auto* multi = static_cast<CURLM*>(multi_);
  int still_running = 0;
  static_cast<void>(curl().multi_perform(multi, &still_running));
  curl_waitfd other{also, CURL_WAIT_POLLIN, 0};
  // Short: whether a transfer has stalled is seen at its end.
  const double most = running_.empty() ? seconds : std::min(seconds, 0.1);
  static_cast<void>(curl().multi_poll(multi, &other, also >= 0 ? 1u : 0u, static_cast<int>(most * 1000.0), nullptr));
  static_cast<void>(curl().multi_perform(multi, &still_running));
  take_finished();
  give_up_stalled();
}

void HttpTransfers::take_finished() {
  int left = 0;
  while (CURLMsg* message = curl().multi_info_read(static_cast<CURLM*>(multi_), &left)) {
    if (message->msg != CURLMSG_DONE) continue;
    const CURLcode code = message->data.result;
    Transfer* transfer = nullptr;
    static_cast<void>(curl().easy_getinfo(message->easy_handle, CURLINFO_PRIVATE, &transfer));
    long status = 0;
    static_cast<void>(curl().easy_getinfo(message->easy_handle, CURLINFO_RESPONSE_CODE, &status));
    HttpAnswer answer = std::move(transfer->answer);
    answer.status = static_cast<int>(status);
    answer.content_bytes = transfer->content_bytes();
    answer.trouble = transfer->too_large ? HttpTrouble::too_large : trouble_of(code);
    if (answer.trouble != HttpTrouble::none) {
      answer.body.clear();
      const char* words = transfer->error[0] != '\0' ? transfer->error.data() : curl().easy_strerror(code);
      answer.why =
          transfer->too_large ? "it sends more than " + std::to_string(transfer->request.most_bytes / 1'000'000) + " MB" : printable(words);
    }
    finish(*transfer, std::move(answer));
  }
}

void HttpTransfers::give_up_stalled() {
  const Clock::time_point now = Clock::now();
  // Time in which this process did something else is none in which the server was slow.
  const auto away = now - std::exchange(last_step_, now) - std::chrono::milliseconds(200);
  std::vector<Transfer*> stalled;
  for (const auto& transfer : running_) {
    if (away.count() > 0) transfer->mark = std::min(now, transfer->mark + away);
    if (transfer->moved() >= transfer->mark_bytes + transfer->request.stall_bytes) {
      transfer->mark = now;
      transfer->mark_bytes = transfer->moved();
    }
    if (std::chrono::duration<double>(now - transfer->mark).count() > transfer->request.stall_seconds) stalled.push_back(transfer.get());
  }
  for (Transfer* transfer : stalled) {
    char why[96];
    const HttpRequest& request = transfer->request;
    if (transfer->moved() > transfer->mark_bytes)
      static_cast<void>(std::snprintf(why, sizeof why, "it is slow: less than %.0f kB in %.3g s",
                                      static_cast<double>(request.stall_bytes) / 1e3, request.stall_seconds));
    else
      static_cast<void>(std::snprintf(why, sizeof why, "it gave no answer in %.3g s", request.stall_seconds));
    finish(*transfer, HttpAnswer{.trouble = HttpTrouble::too_slow, .why = why});
  }
}

void HttpTransfers::finish(Transfer& transfer, HttpAnswer answer) {
  const auto at = std::ranges::find(running_, &transfer, [](const auto& running) { return running.get(); });
  const std::unique_ptr<Transfer> ended = std::move(*at);
  running_.erase(at);
  // First what waits for the answer: libcurl may take its time.
  ended->done(std::move(answer));
  curl().multi_remove_handle(static_cast<CURLM*>(multi_), ended->easy);
  curl().easy_cleanup(ended->easy);
}

bool is_success(int status) {
  return status >= 200 && status < 300;
}

bool is_absent(int status) {
  return status == 404 || status == 410;
}

std::string status_text(int status) {
  static const std::map<int, const char*> words = {
      {301, "moved: name the address that it has now"},
      {302, "moved: name the address that it has now"},
      {308, "moved: name the address that it has now"},
      {401, "it wants credentials, in COPPICE_CACHE_CREDENTIALS or ~/.netrc, or others than these"},
      {403, "forbidden"},
      {404, "not found"},
      {405, "method not allowed"},
      {409, "conflict: the server makes no folders; nginx does with create_full_put_path on"},
      {413, "too large for the server; nginx takes more with client_max_body_size"},
      {429, "too many requests"},
      {500, "internal error"},
      {502, "bad gateway"},
      {503, "service unavailable"},
      {504, "gateway timeout"},
      {507, "no room left"},
  };
  const auto found = words.find(status);
  return "it answers " + std::to_string(status) + (found != words.end() ? std::string(" (") + found->second + ")" : "");
}

}  // namespace coppice::bake
