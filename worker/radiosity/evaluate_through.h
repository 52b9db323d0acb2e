// Makes and judges links through mirrors, for refine.cc.
#pragma once

#include <functional>

#include "worker/radiosity/refine.h"

namespace isolux {

// Of p and an image of q, which may be p itself; link.p and link.q are set. judge: by the values of
// now. `rays` gets how many were cast.
LinkVerdict EvaluateThrough(const RefineScene& scene, const Tree& tree, double epsilon_w,
                            uint32_t image, const std::function<LinkVerdict(const Link&)>& judge,
                            Link& link, uint8_t* rays);

}  // namespace isolux
