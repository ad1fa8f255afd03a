// The local page of a scan, over HTTP.
#pragma once

#include <memory>
#include <string>

#include "capture/page/live_page.h"

namespace reseau {

struct PageAddress {
  std::string host = "127.0.0.1";
  int port = 0;  // 0: any that is free
};
// "127.0.0.1:8080", "8080", "[::1]:8080"; InputError, a sentence, otherwise.
[[nodiscard]] PageAddress parse_page_address(const std::string& text);

// Answers GET of / (the page), /state.json, /strip/N.png, /picture.png and /receipt.json, the last
// two once there are such files. Everything comes from here, nothing from other places. On a
// loopback address it also turns away requests for another host's name, which pages of other places
// could send. Owns its threads.
class PageServer {
 public:
  // The page must outlive this. Throws InputError where the address cannot be had.
  PageServer(const PageAddress& address, const LivePage& page);
  // Ends at once; requests that are being answered get their answer.
  ~PageServer();
  PageServer(const PageServer&) = delete;
  PageServer& operator=(const PageServer&) = delete;

  // "http://127.0.0.1:40123/"
  [[nodiscard]] const std::string& url() const;
  // Whether somebody looks at the page and has not yet been given all that there is at the end.
  [[nodiscard]] bool owes_the_end() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace reseau
