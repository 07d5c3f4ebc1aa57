#include "cli/name_services.h"

#ifdef MESHGAUGE_STATIC
#include <nss.h>

#include <initializer_list>
#endif

namespace meshgauge::cli {

void use_built_in_name_services() {
#ifdef MESHGAUGE_STATIC
  __nss_configure_lookup("hosts", "files dns");
  for (const char* database : {"passwd", "group", "services", "protocols", "networks"})
    __nss_configure_lookup(database, "files");
#endif
}

}  // namespace meshgauge::cli
