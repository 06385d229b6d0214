// HTTP for a page: the only file that uses the server library.
#include <fmt/format.h>

#include <cerrno>
#include <cstring>
#include <system_error>
#include <thread>

#include "page/connections.h"
#include "page/page.h"
#include "page/page_json.h"

// Last: system headers in it define macros that Eigen stumbles over.
#include <httplib.h>

namespace foldproof {
namespace {

// Notebooks that this machine serves show the page in a frame.
constexpr const char* kSecurityPolicy =
    "default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' data: blob:; "
    "connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors http://127.0.0.1:* "
    "http://localhost:*";

/// The head of a request, and a buffer for the answer.
class Exchange : public httplib::Stream {
 public:
  explicit Exchange(std::string_view head) : head_(head) {}

  std::string answer;
  bool fully_read() const { return head_.empty(); }

  bool is_readable() const override { return !head_.empty(); }
  bool is_writable() const override { return true; }
  ssize_t read(char* to, std::size_t size) override {
    const std::size_t count = head_.copy(to, size);
    head_.remove_prefix(count);
    return static_cast<ssize_t>(count);
  }
  ssize_t write(const char* from, std::size_t size) override {
    answer.append(from, size);
    return static_cast<ssize_t>(size);
  }
  void get_remote_ip_and_port(std::string&, int&) const override {}
  void get_local_ip_and_port(std::string&, int&) const override {}
  socket_t socket() const override { return INVALID_SOCKET; }

 private:
  std::string_view head_;
};

/// Parses requests and formats answers. The library's own server is not used: it needs a thread per
/// connection and reads lines of any length.
struct Http : httplib::Server {
  /// False: not a valid request. `close`: the connection cannot be used for another request.
  bool process(Exchange& exchange, bool& close) {
    // True also when the library rejects a head before it has parsed it.
    bool has_body = true;
    const auto prepare = [&](httplib::Request& request) {
      // Bodies are not read. Without closing the connection, a body would be parsed as the next request.
      has_body = (request.method != "GET" && request.method != "HEAD") ||
                 request.has_header("Content-Length") || request.has_header("Transfer-Encoding");
      if (has_body) {
        request.headers.erase("Connection");
        request.set_header("Connection", "close");
      }
      // Overlapping ranges could make an answer larger than its content, compression takes longer than a
      // local transfer, and without bodies there is nothing to continue.
      request.ranges.clear();
      request.headers.erase("Range");
      request.headers.erase("Accept-Encoding");
      request.headers.erase("Expect");
    };
    const bool answered = process_request(exchange, false, close, prepare);
    close = close || has_body;
    return answered && exchange.fully_read();
  }
};

const char* type_of(std::string_view path) {
  constexpr std::array<std::pair<std::string_view, const char*>, 7> kTypes{
      {{".html", "text/html; charset=utf-8"},
       {".js", "text/javascript; charset=utf-8"},
       {".css", "text/css; charset=utf-8"},
       {".json", "application/json"},
       {".svg", "image/svg+xml"},
       {".png", "image/png"},
       {".woff2", "font/woff2"}}};
  for (const auto& [ending, type] : kTypes) {
    if (path.ends_with(ending)) return type;
  }
  return "application/octet-stream";
}

PageAnswer error_answer(int status, const std::string& line) {
  return {status, "application/json", error_json(line)};
}

// In a DNS rebinding attack, a foreign host name resolves to this machine, but the Host header has that name.
bool is_this_machine(const httplib::Request& request, int port) {
  if (request.get_header_value_count("Host") != 1) return false;
  const std::string host = request.get_header_value("Host");
  for (const char* name : {"127.0.0.1", "localhost", "[::1]"}) {
    // Browsers leave out port 80.
    if (host == fmt::format("{}:{}", name, port) || (port == 80 && host == name)) return true;
  }
  return false;
}

void send(PageAnswer answer, httplib::Response& response) {
  response.status = answer.status;
  response.body = std::move(answer.body);
  response.set_header("Content-Type", answer.type);
}

/// A complete HTTP answer to an invalid request; closes the connection.
std::string refusal(const char* status, const char* line) {
  const std::string body = error_json(line);
  return fmt::format(
      "HTTP/1.1 {}\r\nContent-Type: application/json\r\nContent-Length: {}\r\nConnection: close\r\n\r\n{}",
      status, body.size(), body);
}

}  // namespace

struct PageServer::Impl {
  Page* page = nullptr;
  std::map<std::string, std::string_view, std::less<>> files;  // by URL path
  int port = 0;
  Http http;
  Connections connections;

  PageAnswer answer(const httplib::Request& request) const;
  Reply reply(const std::string& head);
  int listen(int wanted);
  void prepare();
};

PageAnswer PageServer::Impl::answer(const httplib::Request& request) const {
  if (!is_this_machine(request, port))
    return error_answer(403, "this page is for the machine that it runs on");
  if (request.method != "GET" && request.method != "HEAD")
    return error_answer(405, "there is nothing but GET here");
  if (request.path.starts_with("/api/"))
    return page->get(request.path, {request.params.begin(), request.params.end()});
  const auto file = files.find(request.path);
  if (file == files.end()) return error_answer(404, "there is nothing here");
  return {200, type_of(file->first == "/" ? ".html" : file->first), std::string(file->second)};
}

Reply PageServer::Impl::reply(const std::string& head) {
  try {
    Exchange exchange(head);
    bool close = false;
    if (http.process(exchange, close)) return {std::move(exchange.answer), close};
  } catch (const std::exception&) {
    // The library may throw on invalid requests.
  }
  return {refusal("400 Bad Request", "this is no request"), true};
}

void PageServer::Impl::prepare() {
  http.set_keep_alive_timeout(Connections::kHeadTime.count());
  http.set_keep_alive_max_count(1'000'000);
  http.set_default_headers({{"Content-Security-Policy", kSecurityPolicy},
                            {"X-Content-Type-Options", "nosniff"},
                            {"Referrer-Policy", "no-referrer"},
                            {"Cross-Origin-Resource-Policy", "same-origin"},
                            {"Cache-Control", "no-store"}});
  http.set_pre_routing_handler([this](const httplib::Request& request, httplib::Response& response) {
    send(answer(request), response);
    return httplib::Server::HandlerResponse::Handled;
  });
  http.set_exception_handler(
      [](const httplib::Request&, httplib::Response& response, const std::exception_ptr& thrown) {
        try {
          std::rethrow_exception(thrown);
        } catch (const std::exception& error) {
          send(error_answer(500, line_of(error)), response);
        }
      });
}

int PageServer::Impl::listen(int wanted) {
  const int code = connections.listen(wanted);
  if (code == 0) port = wanted;
  return code;
}

bool is_taken(int code) { return code == EADDRINUSE || code == EACCES; }

PageServer::PageServer(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
PageServer::~PageServer() = default;
PageServer::PageServer(PageServer&&) noexcept = default;
PageServer& PageServer::operator=(PageServer&&) noexcept = default;

int PageServer::port() const { return impl_->port; }

Result<PageServer> PageServer::open(Page& page, std::span<const PageFile> files, int port) {
  constexpr std::string_view kFolder = "view";
  auto impl = std::make_unique<Impl>();
  impl->page = &page;
  for (const PageFile& file : files) {
    if (file.path == "view/index.html") impl->files["/"] = file.bytes;
    if (file.path.starts_with("view/"))
      impl->files[std::string(file.path.substr(kFolder.size()))] = file.bytes;
  }
  impl->prepare();
  const int last = port != 0 ? port : kFirstPagePort + kPagePorts - 1;
  int code = EADDRINUSE;
  for (int k = port != 0 ? port : kFirstPagePort; k <= last && is_taken(code); ++k) code = impl->listen(k);
  if (code == 0) return PageServer(std::move(impl));
  if (!is_taken(code)) {
    return fail(ErrorCode::FileAccess, "the page's server",
                "cannot listen: " + std::generic_category().message(code),
                "check the network settings and the limits of this machine");
  }
  if (port != 0)
    return fail(ErrorCode::FileAccess, fmt::format("port {}", port), "is taken, or not yours to take",
                "give another, or none: a free one is found");
  return fail(ErrorCode::FileAccess, fmt::format("ports {} to {}", kFirstPagePort, last), "are all taken",
              "name a free one with --port");
}

Result<void> PageServer::serve(const std::atomic<bool>& stop) {
  std::atomic<bool> ended = false;
  std::thread worker;
  try {
    worker = std::thread([&] { impl_->page->work(ended); });
  } catch (const std::system_error& error) {
    return fail(ErrorCode::LimitExceeded, "the page", std::string("cannot start: ") + error.what(),
                "end other programs, or raise the limit on threads");
  }
  const RequestHandler handler{[this](const std::string& head) { return impl_->reply(head); },
                               refusal("431 Request Header Fields Too Large", "this request is too long")};
  auto served = impl_->connections.serve(handler, stop, ended);
  worker.join();
  return served;
}

}  // namespace foldproof
