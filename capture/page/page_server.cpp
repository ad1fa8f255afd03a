#include "capture/page/page_server.h"

#include <algorithm>
#include <atomic>
#include <charconv>
#include <fstream>
#include <ios>
#include <memory>
#include <string>
#include <system_error>
#include <thread>

#include <fmt/format.h>
#include <httplib.h>
#include <sys/socket.h>

#include "capture/page/page_html.h"
#include "core/base/error.h"

namespace reseau {
namespace {

constexpr int kThreads = 4;

bool is_loopback(const std::string& host) {
  return host == "localhost" || host == "::1" || host.rfind("127.", 0) == 0;
}

// The name in a Host header, without the port.
std::string host_name(const std::string& header) {
  if (header.rfind('[', 0) == 0) return header.substr(1, header.find(']') - 1);
  return header.substr(0, header.rfind(':'));
}

void send_file(const std::filesystem::path& path, const char* type, httplib::Response& response) {
  const auto file = std::make_shared<std::ifstream>(path, std::ios::binary);
  std::error_code gone;
  const auto size = path.empty() ? 0 : std::filesystem::file_size(path, gone);
  if (size == 0 || gone || !*file) {
    response.status = 404;
    return;
  }
  response.set_content_provider(
      size, type, [file](std::size_t offset, std::size_t n, httplib::DataSink& sink) {
        std::string part(std::min<std::size_t>(n, 1 << 20), '\0');
        file->seekg(static_cast<std::streamoff>(offset));
        if (!file->read(part.data(), static_cast<std::streamsize>(part.size()))) return false;
        return sink.write(part.data(), part.size());
      });
}

}  // namespace

PageAddress parse_page_address(const std::string& text) {
  PageAddress address;
  const std::size_t colon = text.rfind(':');
  const std::string port = colon == std::string::npos ? text : text.substr(colon + 1);
  if (colon != std::string::npos) address.host = text.substr(0, colon);
  if (address.host.size() > 2 && address.host.front() == '[' && address.host.back() == ']')
    address.host = address.host.substr(1, address.host.size() - 2);
  const char* const end = port.data() + port.size();
  const auto parsed = std::from_chars(port.data(), end, address.port);
  if (parsed.ec != std::errc() || parsed.ptr != end || address.port < 0 || address.port > 65535 ||
      address.host.empty()) {
    throw InputError("\"" + text +
                     "\" is no address for a page. Write HOST:PORT, for example 127.0.0.1:8080, or "
                     "only the port.");
  }
  return address;
}

struct PageServer::State {
  const LivePage& page;
  httplib::Server server;
  std::string url;
  // What was asked for: the state at all, and at the end what the page then asks for.
  std::atomic<bool> looked_at = false, end_seen = false, view_sent = false, receipt_sent = false;
  std::jthread thread;  // last: it uses all others

  explicit State(const LivePage& shown) : page(shown) {}
  void answer(bool only_local);
};

void PageServer::State::answer(bool only_local) {
  server.set_default_headers(
      {{"Cache-Control", "no-store"},
       {"X-Content-Type-Options", "nosniff"},
       {"Content-Security-Policy",
        "default-src 'none'; img-src 'self'; connect-src 'self'; style-src 'unsafe-inline'; "
        "script-src 'unsafe-inline'"}});
  if (only_local) {
    server.set_pre_routing_handler(
        [](const httplib::Request& request, httplib::Response& response) {
          if (is_loopback(host_name(request.get_header_value("Host"))))
            return httplib::Server::HandlerResponse::Unhandled;
          response.status = 403;
          return httplib::Server::HandlerResponse::Handled;
        });
  }
  server.Get("/", [](const httplib::Request&, httplib::Response& response) {
    response.set_content(page_html().data(), page_html().size(), "text/html; charset=utf-8");
  });
  server.Get("/state.json", [this](const httplib::Request&, httplib::Response& response) {
    // Whether the scan has ended is asked for before the state, which says so then.
    const bool ended = page.ended();
    response.set_content(page.state_json(), "application/json");
    looked_at = true;
    if (ended) end_seen = true;
  });
  server.Get(R"(/strip/(\d{1,6})\.png)",
             [this](const httplib::Request& request, httplib::Response& response) {
               const auto png = page.strip_png(std::stoi(request.matches[1].str()));
               if (png) {
                 response.set_content(*png, "image/png");
               } else {
                 response.status = 404;
               }
             });
  server.Get("/picture.png", [this](const httplib::Request&, httplib::Response& response) {
    send_file(page.view(), "image/png", response);
    view_sent = true;
  });
  server.Get("/receipt.json", [this](const httplib::Request&, httplib::Response& response) {
    send_file(page.receipt(), "application/json", response);
    receipt_sent = true;
  });
}

PageServer::PageServer(const PageAddress& address, const LivePage& page)
    : state_(std::make_unique<State>(page)) {
  httplib::Server& server = state_->server;
  server.new_task_queue = [] { return new httplib::ThreadPool(kThreads); };
  // A connection for every request: none is left to be waited for at the end.
  server.set_keep_alive_max_count(1);
  server.set_tcp_nodelay(true);
  // The library's own would share the port with another program that has it.
  server.set_socket_options([](socket_t socket) {
    const int yes = 1;
    ::setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  });
  state_->answer(is_loopback(address.host));
  const int port =
      address.port == 0
          ? server.bind_to_any_port(address.host.c_str())
          : (server.bind_to_port(address.host.c_str(), address.port) ? address.port : -1);
  if (port < 0) {
    throw InputError(fmt::format(
        "The page cannot be had at {}:{}: another program has that address, or it is none of this "
        "machine. Choose another port.",
        address.host, address.port));
  }
  const bool v6 = address.host.find(':') != std::string::npos;
  state_->url = fmt::format("http://{}:{}/", v6 ? "[" + address.host + "]" : address.host, port);
  state_->thread = std::jthread([&server] { server.listen_after_bind(); });
  while (!server.is_running()) std::this_thread::yield();
}

PageServer::~PageServer() { state_->server.stop(); }

const std::string& PageServer::url() const { return state_->url; }

bool PageServer::owes_the_end() const {
  const State& s = *state_;
  if (!s.looked_at || !s.page.ended()) return s.looked_at;
  return !s.end_seen || (!s.page.view().empty() && !s.view_sent) ||
         (!s.page.receipt().empty() && !s.receipt_sent);
}

}  // namespace reseau
