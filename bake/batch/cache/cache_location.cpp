#include "cache_location.h"

#include <curl/curl.h>

#include <cstdlib>
#include <memory>
#include <string_view>

namespace coppice::bake {
namespace {

using Url = std::unique_ptr<CURLU, decltype(&::curl_url_cleanup)>;

/// Empty where the address has none.
std::string part_of(const Url& url, CURLUPart part) {
  char* text = nullptr;
  if (::curl_url_get(url.get(), part, &text, 0) != CURLUE_OK) return {};
  std::string copy(text);
  ::curl_free(text);
  return copy;
}

Error refused(const char* what, const std::string& where = {}) {
  return Error{Status::invalid_argument, what, Error::kNoOffset, where};
}

Result<std::string> checked_url(const std::string& text) {
  const Url url(::curl_url(), &::curl_url_cleanup);
  if (!url) return Error{Status::out_of_memory, "out of memory"};
  const auto part = [&](CURLUPart wanted) { return part_of(url, wanted); };
  if (::curl_url_set(url.get(), CURLUPART_URL, text.c_str(), CURLU_NON_SUPPORT_SCHEME) != CURLUE_OK)
    return refused("the cache's address cannot be read: it is like https://host/path");
  const std::string scheme = part(CURLUPART_SCHEME), host = part(CURLUPART_HOST);
  if (scheme != "http" && scheme != "https") return refused("a cache's address begins with http:// or https://, or it is a folder", scheme);
  if (!part(CURLUPART_USER).empty() || !part(CURLUPART_PASSWORD).empty())
    return refused("no user or password in the cache's address, where others see it: put them into COPPICE_CACHE_CREDENTIALS or ~/.netrc",
                   host);
  if (!part(CURLUPART_QUERY).empty() || !part(CURLUPART_FRAGMENT).empty()) return refused("a cache's address has no ? and no #", host);
  std::string whole = part(CURLUPART_URL);
  while (whole.ends_with('/')) whole.pop_back();
  return whole;
}

/// "user:password@host/path" without what is before the @, which nobody is to see.
std::string without_user(const std::string& text) {
  const std::size_t at = text.find('@');
  return at < text.find('/') ? text.substr(at + 1) : text;
}

/// "host:8080/path" or "user:password@host/path", where no such folder is.
bool is_like_an_address(const std::string& text) {
  const std::size_t colon = text.find(':'), slash = text.find('/');
  std::error_code error;
  if (colon == std::string::npos || colon == 0 || colon > slash || std::filesystem::exists(text, error)) return false;
  if (without_user(text) != text) return true;
  const std::string port = text.substr(colon + 1, slash == std::string::npos ? slash : slash - colon - 1);
  return !port.empty() && port.find_first_not_of("0123456789") == std::string::npos;
}

}  // namespace

Result<CacheLocation> parse_cache_location(const std::string& text) {
  if (text.empty()) return refused("a cache needs a folder or an address");
  if (is_like_an_address(text))
    return refused("a cache's address begins with http:// or https://; a folder of that name is called ./NAME", without_user(text));
  if (text.find("://") == std::string::npos) return CacheLocation{text, {}};
  COPPICE_TRY(url, checked_url(text));
  return CacheLocation{{}, std::move(url)};
}

Result<CacheCredentials> credentials_of_environment() {
  const char* value = std::getenv(kCredentialsVariable);
  const std::string_view text = value != nullptr ? value : "";
  if (text.empty()) return CacheCredentials{};
  constexpr std::string_view kBearer = "Bearer ";
  const std::size_t colon = text.find(':');
  const bool one_line = text.find_first_of("\r\n") == std::string_view::npos;
  if (one_line && text.starts_with(kBearer)) return CacheCredentials{{}, {}, std::string(text.substr(kBearer.size()))};
  if (!one_line || colon == std::string_view::npos || colon == 0)
    return refused("COPPICE_CACHE_CREDENTIALS is neither USER:PASSWORD nor Bearer TOKEN");
  return CacheCredentials{std::string(text.substr(0, colon)), std::string(text.substr(colon + 1)), {}};
}

}  // namespace coppice::bake
