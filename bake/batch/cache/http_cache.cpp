#include "http_cache.h"

#include <curl/curl.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <new>
#include <utility>

#include "printable.h"
#include "text_bytes.h"

namespace coppice::bake {
namespace {

// What a request may cost beside RequestLimits: the time to connect, and the time for which it may be slower than the limit.
constexpr long kConnectSeconds = 2, kSlowSeconds = 3, kSlowBytesPerSecond = 100'000;

/// As much as is read of what is no entry's file.
constexpr std::uint64_t kMaxOtherBytes = std::uint64_t{64} << 10;

struct Download {
  CURL* easy;
  std::vector<std::uint8_t>* bytes;
  std::uint64_t max_bytes;
};

long status_of(CURL* easy) {
  long status = 0;
  ::curl_easy_getinfo(easy, CURLINFO_RESPONSE_CODE, &status);
  return status;
}

std::size_t receive(char* data, std::size_t size, std::size_t count, void* user) {
  Download& to = *static_cast<Download*>(user);
  const std::size_t bytes = size * count;
  const std::uint64_t max_bytes = status_of(to.easy) == 200 ? to.max_bytes : std::min(to.max_bytes, kMaxOtherBytes);
  if (to.bytes->size() + bytes > max_bytes) return 0;  // libcurl takes it for a failure
  to.bytes->insert(to.bytes->end(), data, data + bytes);
  return bytes;
}

std::size_t send(char* data, std::size_t size, std::size_t count, void* user) {
  auto& left = *static_cast<std::span<const std::uint8_t>*>(user);
  const std::size_t bytes = std::min(size * count, left.size());
  if (bytes > 0) std::memcpy(data, left.data(), bytes);
  left = left.subspan(bytes);
  return bytes;
}

template <class T>
void set(CURL* easy, CURLoption option, T value) {
  if (::curl_easy_setopt(easy, option, value) == CURLE_OUT_OF_MEMORY) throw std::bad_alloc();
}

Error refused(long status) {
  std::string text = "HTTP " + std::to_string(status);
  if (status == 401 || status == 403) text += std::string(" (credentials are in ") + kCredentialsVariable + " or ~/.netrc)";
  return Error{Status::io, "the server refuses", Error::kNoOffset, std::move(text)};
}

}  // namespace

struct HttpCache::Connection {
  CURL* easy = nullptr;
  curl_slist* headers = nullptr;
  std::array<char, CURL_ERROR_SIZE> error{};

  explicit Connection(const CacheCredentials& credentials) {
    static const CURLcode ready = ::curl_global_init(CURL_GLOBAL_DEFAULT);
    easy = ready == CURLE_OK ? ::curl_easy_init() : nullptr;
    if (easy == nullptr) throw std::bad_alloc();
    // A server that does not know "Expect" would be waited for.
    headers = ::curl_slist_append(nullptr, "Expect:");
    if (!credentials.token.empty()) headers = ::curl_slist_append(headers, ("Authorization: Bearer " + credentials.token).c_str());
    set(easy, CURLOPT_HTTPHEADER, headers);
    set(easy, CURLOPT_ERRORBUFFER, error.data());
    set(easy, CURLOPT_NOSIGNAL, 1L);
    set(easy, CURLOPT_PROTOCOLS_STR, "http,https");
    set(easy, CURLOPT_USERAGENT, "coppice");
    set(easy, CURLOPT_CONNECTTIMEOUT, kConnectSeconds);
    set(easy, CURLOPT_LOW_SPEED_TIME, kSlowSeconds);
    set(easy, CURLOPT_LOW_SPEED_LIMIT, kSlowBytesPerSecond);
    set(easy, CURLOPT_WRITEFUNCTION, &receive);
    set(easy, CURLOPT_READFUNCTION, &send);
    if (!credentials.user.empty()) {
      set(easy, CURLOPT_USERNAME, credentials.user.c_str());
      set(easy, CURLOPT_PASSWORD, credentials.password.c_str());
    } else if (credentials.token.empty()) {
      set(easy, CURLOPT_NETRC, static_cast<long>(CURL_NETRC_OPTIONAL));
    }
  }
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;
  ~Connection() {
    ::curl_easy_cleanup(easy);
    ::curl_slist_free_all(headers);
  }
};

HttpCache::HttpCache(std::string url, CacheCredentials credentials, double most_lost_s)
    : FailureCount(most_lost_s), url_(std::move(url)), credentials_(std::move(credentials)) {}
HttpCache::HttpCache(HttpCache&&) noexcept = default;
HttpCache::~HttpCache() = default;

Result<HttpCache::Answer> HttpCache::request(const std::string& file, const std::span<const std::uint8_t>* body,
                                             const RequestLimits& limits) {
  if (is_off()) return Error{Status::io, "the server failed or took too much time, and is asked no more"};
  if (!connection_) connection_ = std::make_unique<Connection>(credentials_);
  CURL* easy = connection_->easy;
  Answer answer;
  Download download{easy, &answer.body, limits.bytes};
  std::span<const std::uint8_t> left = body != nullptr ? *body : std::span<const std::uint8_t>();
  set(easy, CURLOPT_URL, (url_ + "/" + file).c_str());
  // Large entries take longer.
  constexpr double kBytesPerSecond = 4e6;
  const double seconds = limits.seconds + static_cast<double>(body != nullptr ? body->size() : limits.bytes) / kBytesPerSecond;
  set(easy, CURLOPT_TIMEOUT_MS, static_cast<long>(1000.0 * seconds));
  set(easy, CURLOPT_MAXFILESIZE_LARGE, static_cast<curl_off_t>(limits.bytes));
  set(easy, CURLOPT_WRITEDATA, &download);
  set(easy, CURLOPT_READDATA, &left);
  if (body != nullptr) {
    set(easy, CURLOPT_UPLOAD, 1L);
    set(easy, CURLOPT_INFILESIZE_LARGE, static_cast<curl_off_t>(body->size()));
  } else {
    set(easy, CURLOPT_HTTPGET, 1L);
  }
  connection_->error[0] = '\0';
  const CURLcode code = ::curl_easy_perform(easy);
  if (code != CURLE_OK) {
    count(true);
    const char* why = connection_->error[0] != '\0' ? connection_->error.data() : ::curl_easy_strerror(code);
    return Error{Status::io, "the server is of no use", Error::kNoOffset, printable(why)};
  }
  answer.status = status_of(easy);
  return answer;
}

Result<std::optional<std::vector<std::uint8_t>>> HttpCache::get_file(const std::string& file, const RequestLimits& limits) {
  COPPICE_TRY(answer, request(file, nullptr, limits));
  const bool is_absent = answer.status == 404 || answer.status == 410;
  count(answer.status != 200 && !is_absent);
  if (answer.status == 200) return std::optional(std::move(answer.body));
  if (is_absent) return std::optional<std::vector<std::uint8_t>>();
  return refused(answer.status);
}

Result<void> HttpCache::put_file(const std::string& file, std::span<const std::uint8_t> bytes, const RequestLimits& limits) {
  COPPICE_TRY(answer, request(file, &bytes, {kMaxOtherBytes, limits.seconds}));
  const bool is_kept = answer.status >= 200 && answer.status < 300;
  count(!is_kept);
  return is_kept ? Result<void>() : refused(answer.status);
}

Result<std::optional<CachedBake>> HttpCache::get(const std::string& key, const RequestLimits& limits) {
  COPPICE_TRY(record, get_file(key + ".record", {kMaxRecordBytes, limits.seconds}));
  if (!record) return std::optional<CachedBake>();
  const Error damaged{Status::bad_file, "an entry of the cache is damaged", Error::kNoOffset, url_ + "/" + key};
  if (key_of(parts_of_record(*record)) != key) return damaged;
  COPPICE_TRY(bytes, get_file(key + ".coppice", limits));
  if (!bytes) return std::optional<CachedBake>();
  auto entry = read_entry(*record, *std::move(bytes), key);
  if (!entry) return damaged;
  return std::optional(*std::move(entry));
}

Result<void> HttpCache::put(const std::string& key, const CachedBake& entry, const RequestLimits& limits) {
  COPPICE_CHECK(put_file(key + ".coppice", entry.bytes, limits));
  const std::string record = record_text(entry);
  return put_file(key + ".record", bytes_of(record), limits);
}

}  // namespace coppice::bake
