// What the module with OpenImageIO offers; a plain C interface between two shared objects.
#pragma once

extern "C" {

struct ReseauPicture {
  int width_px, height_px;
  float* rgb;        // [row][pixel][R G B], linear; owned by the module until free
  char error[1024];  // a sentence, empty when it worked
};

// Never throws. The result is given back to reseau_free_picture(), error or not.
void reseau_read_picture(const char* path, ReseauPicture* out);
void reseau_free_picture(ReseauPicture* picture);
}
