// HTTP for a page: the only file that uses the server library.
#include <fmt/format.h>

#include <thread>

#include "page/page.h"
#include "page/page_json.h"
#include "page/query.h"
#include "system/socket.h"

// Last: system headers in it define macros that Eigen stumbles over.
#include <httplib.h>

namespace foldproof {
namespace {

// Notebooks that this machine serves show the page in a frame.
constexpr const char* kSecurityPolicy =
    "default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' data: blob:; "
    "connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors http://127.0.0.1:* "
    "http://localhost:*";

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
  // Not get_header_value: it ends at a NUL, and the library decodes "%00".
  const auto [first, last] = request.headers.equal_range("Host");
  if (std::distance(first, last) != 1) return false;
  const std::string& host = first->second;
  for (const char* name : {"127.0.0.1", "localhost", "[::1]"}) {
    // Browsers leave out port 80.
    if (host == fmt::format("{}:{}", name, port) || (port == 80 && host == name)) return true;
  }
  return false;
}

void send(PageAnswer answer, httplib::Response& response) {
  if (answer.status != 200) response.status = answer.status;  // 206 if the request names a range
  if (answer.body.empty()) return response.set_content("", answer.type);
  // As response.body, it would be compressed, which takes longer than sending it on this machine. What the
  // library asks for may end after the body, as it does not check ranges.
  const auto body = std::make_shared<const std::string>(std::move(answer.body));
  response.set_content_provider(
      body->size(), answer.type, [body](std::size_t offset, std::size_t length, httplib::DataSink& sink) {
        if (offset >= body->size()) return false;
        return sink.write(body->data() + offset, std::min(length, body->size() - offset));
      });
}

class HttpServer : public httplib::Server {
 public:
  HttpServer() {
    // A thread waits for each connection that has sent no request. Browsers open some of them ahead.
    new_task_queue = [] { return new httplib::ThreadPool(32); };
    set_read_timeout(5);
    set_write_timeout(30);
    // A request per connection: what follows it, such as a body, is never taken for another request, with a
    // Host header of its own; and no thread waits for the next one.
    set_keep_alive_max_count(1);
    set_tcp_nodelay(true);
    // In place of the library's SO_REUSEPORT, with which two servers could share a port.
    set_socket_options([](socket_t socket) { system::take_ended_port(static_cast<std::intptr_t>(socket)); });
    set_default_headers({{"Content-Security-Policy", kSecurityPolicy},
                         {"X-Content-Type-Options", "nosniff"},
                         {"Referrer-Policy", "no-referrer"},
                         {"Cross-Origin-Resource-Policy", "same-origin"},
                         {"Cache-Control", "no-store"}});
  }
  ~HttpServer() override {
    if (svr_sock_ != INVALID_SOCKET) system::close_socket(static_cast<std::intptr_t>(svr_sock_));
  }

  /// False: it cannot listen there; system::socket_error() says why.
  bool listen_on(int port) {
    if (!bind_to_port("127.0.0.1", port)) return false;
    // The library lets 5 connections wait to be accepted. When a browser opens more, they take a second.
    return system::listen(static_cast<std::intptr_t>(svr_sock_));
  }

  /// False: listening failed.
  bool serve() {
    const bool stopped = listen_after_bind();
    svr_sock_ = INVALID_SOCKET;  // closed, but after a failure still named
    return stopped;
  }
};

}  // namespace

struct PageServer::Impl {
  Page* page = nullptr;
  std::map<std::string, std::string_view, std::less<>> files;  // by URL path
  int port = 0;
  std::atomic<bool> ended = false;
  HttpServer http;

  PageAnswer answer(const httplib::Request& request) const;
};

// Starts a repair, whose fixed vertices may be too many for a URL: the parameters stand in the body.
constexpr const char* kPosted = "/api/repair/start";
constexpr std::size_t kLargestBody = std::size_t{4} << 20;

bool is_posted(const httplib::Request& request, int port) {
  return request.method == "POST" && request.path == kPosted && is_this_machine(request, port);
}

PageAnswer PageServer::Impl::answer(const httplib::Request& request) const {
  if (!is_this_machine(request, port))
    return error_answer(403, "this page is for the machine that it runs on");
  if (request.method != "GET" && request.method != "HEAD")
    return error_answer(405, "there is nothing but GET here, and POST to start a repair");
  if (request.path.starts_with("/api/"))
    return page->get(request.path, {request.params.begin(), request.params.end()});
  const auto file = files.find(request.path);
  if (file == files.end()) return error_answer(404, "there is nothing here");
  return {200, type_of(file->first == "/" ? ".html" : file->first), std::string(file->second)};
}

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
  impl->http.set_pre_routing_handler(
      [server = impl.get()](const httplib::Request& request, httplib::Response& response) {
        if (is_posted(request, server->port)) return httplib::Server::HandlerResponse::Unhandled;
        send(server->answer(request), response);
        return httplib::Server::HandlerResponse::Handled;
      });
  impl->http.set_payload_max_length(kLargestBody);
  impl->http.Post(kPosted, [&page](const httplib::Request& request, httplib::Response& response) {
    send(page.get(kPosted, query_of(request.body)), response);
  });
  impl->http.set_exception_handler(
      [](const httplib::Request&, httplib::Response& response, const std::exception_ptr& thrown) {
        try {
          std::rethrow_exception(thrown);
        } catch (const std::exception& error) {
          send(error_answer(500, line_of(error)), response);
        }
      });
  impl->http.set_error_handler([](const httplib::Request&, httplib::Response& response) {
    if (response.status == 413)  // the library's own answer
      send(error_answer(413, "names too many single vertices; fix larger areas or whole parts"), response);
  });
  const int first = port != 0 ? port : kFirstPagePort, last = port != 0 ? port : first + kPagePorts - 1;
  for (int k = first; k <= last; ++k) {
    impl->port = k;
    if (impl->http.listen_on(k)) return PageServer(std::move(impl));
  }
  const std::string reason = "cannot listen: " + system::socket_error().message();
  if (port != 0)
    return fail(ErrorCode::FileAccess, fmt::format("port {}", port), reason,
                "give another, or none: a free one is found");
  return fail(ErrorCode::FileAccess, fmt::format("ports {} to {}", first, last), reason,
              "name a free one with --port");
}

Result<void> PageServer::serve() {
  std::thread worker([&] { impl_->page->work(impl_->ended); });
  const bool stopped = impl_->http.serve();
  impl_->ended = true;
  worker.join();
  if (stopped) return {};
  return fail(ErrorCode::FileAccess, "the page's server", "can no longer listen", "start it again");
}

void PageServer::stop() {
  // The library ignores a call before it runs.
  while (!impl_->http.is_running() && !impl_->ended) std::this_thread::yield();
  impl_->http.stop();
}

}  // namespace foldproof
