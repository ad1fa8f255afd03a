#include "capture/cli/write_text.h"

#include <span>

#include "capture/cli/failure.h"
#include "capture/store/part_file.h"

namespace reseau::cli {

void write_text(const std::string& path, const std::string& text, Reporter& reporter) {
  as_failure(Doing::kWriting, [&] {
    PartFile file(path, PartFile::Kind::kScratch, Existing::kRefuse);
    file.write_at(0, std::as_bytes(std::span(text)));
    file.publish();
  });
  reporter.say("Written " + path);
}

}  // namespace reseau::cli
