// Includes cpp-httplib; include it only here. Its <resolv.h> defines a macro _res that breaks Eigen's headers if they
// come later.
#pragma once

#include <Eigen/Core>

#include <httplib.h>
