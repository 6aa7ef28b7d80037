/* SPDX-License-Identifier: MIT */
#ifndef IBL_CORE_PI_H
#define IBL_CORE_PI_H

#define IBL_PI 3.14159265358979323846

#endif
