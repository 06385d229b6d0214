// HTTP for a page: the only place that knows the server library.
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

constexpr const char* kSecurityPolicy =
    "default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' data: blob:; "
    "connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

/// The head of a request as it came, and room for what goes back.
class Exchange : public httplib::Stream {
 public:
  explicit Exchange(std::string_view head) : head_(head) {}

  std::string answer;
  bool read_to_its_end() const { return head_.empty(); }

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

/// Reads requests and writes answers. The library's own way of listening is not used: it keeps a thread busy
/// per connection and takes a line of any length.
struct Http : httplib::Server {
  /// False: it is no request. `last`: the connection cannot be used for another.
  bool exchange(Exchange& with, bool& last) {
    // Where the library refuses a head before it has read it, nothing is known of what follows.
    bool announces_more = true;
    const auto look = [&](httplib::Request& request) {
      // Nothing that follows a head is read, so that it could be taken for the next one.
      announces_more = (request.method != "GET" && request.method != "HEAD") ||
                       request.has_header("Content-Length") || request.has_header("Transfer-Encoding");
      if (announces_more) {
        request.headers.erase("Connection");
        request.set_header("Connection", "close");
      }
      // Parts in any number would make an answer larger than what there is; packing takes longer than the way
      // to the next process; and nobody is asked to go on.
      request.ranges.clear();
      request.headers.erase("Range");
      request.headers.erase("Accept-Encoding");
      request.headers.erase("Expect");
    };
    const bool answered = process_request(with, false, last, look);
    last = last || announces_more;
    return answered && with.read_to_its_end();
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

void send(PageAnswer answer, httplib::Response& response) {
  response.status = answer.status;
  response.body = std::move(answer.body);
  response.set_header("Content-Type", answer.type);
}

/// A whole answer to what could not be read as a request, after which the connection is of no use.
std::string refusal(const char* status, const char* line) {
  const std::string body = error_json(line);
  return fmt::format(
      "HTTP/1.1 {}\r\nContent-Type: application/json\r\nContent-Length: {}\r\nConnection: close\r\n\r\n{}",
      status, body.size(), body);
}

}  // namespace

struct PageServer::Impl {
  Page* page = nullptr;
  std::map<std::string, std::string_view, std::less<>> files;  // by what is asked for
  int port = 0;
  Http http;
  Connections connections;

  PageAnswer answer(const httplib::Request& request) const;
  Reply reply(const std::string& head);
  int listen(int wanted);
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

Reply PageServer::Impl::reply(const std::string& head) {
  try {
    Exchange with(head);
    bool last = false;
    if (http.exchange(with, last)) return {std::move(with.answer), last};
  } catch (const std::exception&) {
    // What the library cannot read it may also throw at.
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
      [](const httplib::Request&, httplib::Response& response, const std::exception_ptr&) {
        send(refuse(500, "there is not enough memory for this"), response);
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
    return fail("the page's server", "cannot listen: " + std::generic_category().message(code),
                "check the network settings and the limits of this machine");
  }
  if (port != 0)
    return fail(fmt::format("port {}", port), "is taken, or not yours to take",
                "give another, or none: a free one is found");
  return fail(fmt::format("ports {} to {}", kFirstPagePort, last), "are all taken",
              "name a free one with --port");
}

Result<void> PageServer::serve(const std::atomic<bool>& stop) {
  std::atomic<bool> ended = false;
  std::thread worker;
  try {
    worker = std::thread([&] { impl_->page->work(ended); });
  } catch (const std::system_error& error) {
    return fail("the page", std::string("cannot be worked out: ") + error.what(),
                "end other programs, or raise the limit on threads");
  }
  const Answering answering{[this](const std::string& head) { return impl_->reply(head); },
                            refusal("431 Request Header Fields Too Large", "this request is too long")};
  auto served = impl_->connections.serve(answering, stop, ended);
  worker.join();
  return served;
}

}  // namespace foldproof
