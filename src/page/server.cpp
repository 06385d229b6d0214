// HTTP for a page: the only place that knows the server library.
#include <fmt/format.h>

#include <chrono>
#include <thread>

#include "foldproof/page.h"
#include "page/page_json.h"

// Last: system headers in it define macros that Eigen stumbles over.
#include <httplib.h>

namespace foldproof {
namespace {

using namespace std::chrono_literals;

// A browser opens six connections at a time, and keeps each busy with a thread; two windows have room.
constexpr std::size_t kThreads = 16;
// How long a connection may idle; stopping waits for it. Seconds.
constexpr std::time_t kIdle = 1;

constexpr const char* kSecurityPolicy =
    "default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' data: blob:; "
    "connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

/// Closes what it listens at, also when it never served.
struct Http : httplib::Server {
  ~Http() override {
    if (const auto socket = svr_sock_.exchange(INVALID_SOCKET); socket != INVALID_SOCKET) ::close(socket);
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

PageAnswer refuse(int status, const char* line) { return {status, "application/json", error_json(line)}; }

// Whoever makes a browser believe that another name is this machine (DNS rebinding) still names that other.
bool is_this_machine(const httplib::Request& request, int port) {
  if (request.get_header_value_count("Host") != 1) return false;
  const std::string host = request.get_header_value("Host");
  for (const char* name : {"127.0.0.1", "localhost", "[::1]"}) {
    if (host == fmt::format("{}:{}", name, port)) return true;
  }
  return false;
}

/// The bytes go out as they are: packing them takes longer than the way to the next process.
void send(PageAnswer answer, httplib::Response& response) {
  response.status = answer.status;
  if (answer.body.empty()) return response.set_content("", answer.type);
  const auto body = std::make_shared<const std::string>(std::move(answer.body));
  response.set_content_provider(body->size(), answer.type.c_str(),
                                [body](std::size_t offset, std::size_t length, httplib::DataSink& sink) {
                                  return sink.write(body->data() + offset, length);
                                });
}

}  // namespace

struct PageServer::Impl {
  Page* page = nullptr;
  std::map<std::string, std::string_view, std::less<>> files;  // by what is asked for
  int port = 0;
  Http http;

  PageAnswer answer(const httplib::Request& request) const;
  bool bind(int wanted);
  void prepare();
};

PageAnswer PageServer::Impl::answer(const httplib::Request& request) const {
  if (!is_this_machine(request, port)) return refuse(403, "this page is for the machine that it runs on");
  if (request.method != "GET" && request.method != "HEAD")
    return refuse(405, "there is nothing but GET here");
  if (request.path.starts_with("/api/"))
    return page->get(request.path, {request.params.begin(), request.params.end()});
  const auto file = files.find(request.path);
  if (file == files.end()) return refuse(404, "there is nothing here");
  return {200, type_of(file->first == "/" ? ".html" : file->first), std::string(file->second)};
}

void PageServer::Impl::prepare() {
  http.new_task_queue = [] { return new httplib::ThreadPool(kThreads); };
  http.set_keep_alive_max_count(1'000'000);
  http.set_keep_alive_timeout(kIdle);
  http.set_payload_max_length(0);
  http.set_tcp_nodelay(true);
  // As the library has it, but not SO_REUSEPORT: it would let two programs share a port.
  http.set_socket_options([](socket_t socket) {
    const int yes = 1;
    ::setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  });
  http.set_default_headers({{"Content-Security-Policy", kSecurityPolicy},
                            {"X-Content-Type-Options", "nosniff"},
                            {"Referrer-Policy", "no-referrer"},
                            {"Cross-Origin-Resource-Policy", "same-origin"},
                            {"Cache-Control", "no-store"}});
  http.set_pre_routing_handler([this](const httplib::Request& request, httplib::Response& response) {
    // What follows the head of another request was not read and is no next request.
    if (request.method != "GET" && request.method != "HEAD") response.set_header("Connection", "close");
    send(answer(request), response);
    return httplib::Server::HandlerResponse::Handled;
  });
  http.set_exception_handler([](const httplib::Request&, httplib::Response& response, std::exception_ptr) {
    send(refuse(500, "there is not enough memory for this"), response);
  });
}

bool PageServer::Impl::bind(int wanted) {
  if (!http.bind_to_port("127.0.0.1", wanted)) return false;
  port = wanted;
  return true;
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
  impl->prepare();
  if (port != 0) {
    if (impl->bind(port)) return PageServer(std::move(impl));
    return fail(fmt::format("port {}", port), "is taken, or not yours to take",
                "give another, or none: a free one is found");
  }
  for (int k = 0; k < kPagePorts; ++k) {
    if (impl->bind(kFirstPagePort + k)) return PageServer(std::move(impl));
  }
  return fail(fmt::format("ports {} to {}", kFirstPagePort, kFirstPagePort + kPagePorts - 1), "are all taken",
              "name a free one with --port");
}

void PageServer::serve(const std::atomic<bool>& stop) {
  std::thread listener([&] { impl_->http.listen_after_bind(); });
  std::thread worker([&] { impl_->page->work(stop); });
  // A signal handler sets `stop` and cannot wake anybody.
  while (!stop) std::this_thread::sleep_for(20ms);
  while (!impl_->http.is_running()) std::this_thread::sleep_for(1ms);
  impl_->http.stop();
  listener.join();
  worker.join();
}

}  // namespace foldproof
