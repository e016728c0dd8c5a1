/* Prints what the C compiler makes of Embree's structs: "name number" a line.
   The last part needs C++, where alone the headers define it. */
#include <embree4/rtcore.h>
#include <stddef.h>
#include <stdio.h>

#define SIZE(type) printf(#type " %zu\n", sizeof(struct type))
#define FIELD(type, field) printf(#type "." #field " %zu\n", offsetof(struct type, field))
#define NUMBER(name) printf(#name " %llu\n", (unsigned long long)(name))

#define PACKET(ray_type, hit_type, both) \
  SIZE(ray_type); \
  FIELD(ray_type, org_x); FIELD(ray_type, org_y); FIELD(ray_type, org_z); FIELD(ray_type, tnear); \
  FIELD(ray_type, dir_x); FIELD(ray_type, dir_y); FIELD(ray_type, dir_z); FIELD(ray_type, time); \
  FIELD(ray_type, tfar); FIELD(ray_type, mask); FIELD(ray_type, id); FIELD(ray_type, flags); \
  SIZE(hit_type); \
  FIELD(hit_type, Ng_x); FIELD(hit_type, Ng_y); FIELD(hit_type, Ng_z); FIELD(hit_type, u); \
  FIELD(hit_type, v); FIELD(hit_type, primID); FIELD(hit_type, geomID); FIELD(hit_type, instID); \
  FIELD(hit_type, instPrimID); \
  SIZE(both); \
  FIELD(both, ray); FIELD(both, hit);

int main(void) {
  PACKET(RTCRay4, RTCHit4, RTCRayHit4)
  PACKET(RTCRay8, RTCHit8, RTCRayHit8)
  PACKET(RTCRay16, RTCHit16, RTCRayHit16)

  SIZE(RTCIntersectArguments);
  FIELD(RTCIntersectArguments, flags); FIELD(RTCIntersectArguments, feature_mask);
  FIELD(RTCIntersectArguments, context); FIELD(RTCIntersectArguments, filter);
  FIELD(RTCIntersectArguments, intersect);

  SIZE(RTCOccludedArguments);
  FIELD(RTCOccludedArguments, flags); FIELD(RTCOccludedArguments, feature_mask);
  FIELD(RTCOccludedArguments, context); FIELD(RTCOccludedArguments, filter);
  FIELD(RTCOccludedArguments, occluded);

  SIZE(RTCRayQueryContext);
  FIELD(RTCRayQueryContext, instID); FIELD(RTCRayQueryContext, instPrimID);

  SIZE(RTCFilterFunctionNArguments);
  FIELD(RTCFilterFunctionNArguments, valid); FIELD(RTCFilterFunctionNArguments, geometryUserPtr);
  FIELD(RTCFilterFunctionNArguments, context); FIELD(RTCFilterFunctionNArguments, ray);
  FIELD(RTCFilterFunctionNArguments, hit); FIELD(RTCFilterFunctionNArguments, N);

  SIZE(RTCIntersectFunctionNArguments);
  FIELD(RTCIntersectFunctionNArguments, valid); FIELD(RTCIntersectFunctionNArguments, geometryUserPtr);
  FIELD(RTCIntersectFunctionNArguments, primID); FIELD(RTCIntersectFunctionNArguments, context);
  FIELD(RTCIntersectFunctionNArguments, rayhit); FIELD(RTCIntersectFunctionNArguments, N);
  FIELD(RTCIntersectFunctionNArguments, geomID);

  SIZE(RTCOccludedFunctionNArguments);
  FIELD(RTCOccludedFunctionNArguments, valid); FIELD(RTCOccludedFunctionNArguments, geometryUserPtr);
  FIELD(RTCOccludedFunctionNArguments, primID); FIELD(RTCOccludedFunctionNArguments, context);
  FIELD(RTCOccludedFunctionNArguments, ray); FIELD(RTCOccludedFunctionNArguments, N);
  FIELD(RTCOccludedFunctionNArguments, geomID);

  SIZE(RTCBoundsFunctionArguments);
  FIELD(RTCBoundsFunctionArguments, geometryUserPtr); FIELD(RTCBoundsFunctionArguments, primID);
  FIELD(RTCBoundsFunctionArguments, timeStep); FIELD(RTCBoundsFunctionArguments, bounds_o);

  SIZE(RTCBounds);
  FIELD(RTCBounds, lower_x); FIELD(RTCBounds, lower_y); FIELD(RTCBounds, lower_z);
  FIELD(RTCBounds, upper_x); FIELD(RTCBounds, upper_y); FIELD(RTCBounds, upper_z);

  NUMBER(RTC_INVALID_GEOMETRY_ID);
  NUMBER(RTC_FEATURE_FLAG_ALL);
  NUMBER(RTC_RAY_QUERY_FLAG_COHERENT);
  NUMBER(RTC_RAY_QUERY_FLAG_INVOKE_ARGUMENT_FILTER);
  NUMBER(RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR);

  /* What the inline initializers write, byte by byte. */
  struct RTCIntersectArguments intersect;
  struct RTCOccludedArguments occluded;
  struct RTCRayQueryContext context;
  rtcInitIntersectArguments(&intersect);
  rtcInitOccludedArguments(&occluded);
  rtcInitRayQueryContext(&context);
  printf("intersect.flags %u\n", (unsigned)intersect.flags);
  printf("intersect.feature_mask %u\n", (unsigned)intersect.feature_mask);
  printf("intersect.pointers %d\n", intersect.context || intersect.filter || intersect.intersect);
  printf("occluded.flags %u\n", (unsigned)occluded.flags);
  printf("occluded.feature_mask %u\n", (unsigned)occluded.feature_mask);
  printf("occluded.pointers %d\n", occluded.context || occluded.filter || occluded.occluded);
  printf("context.instID %u\n", context.instID[0]);
  printf("context.instPrimID %u\n", context.instPrimID[0]);

#ifdef __cplusplus
  /* Where the inline accessors find a value in a packet of N rays: what callbacks rely on. */
  enum { N = 3, I = 2 };
  static float rows[64];
  struct RTCRayN *ray = (struct RTCRayN *)rows;
  struct RTCHitN *hit = (struct RTCHitN *)rows;
#define PLACE(name, pointer) printf(name " %d\n", (int)((float *)(pointer) - rows))
  PLACE("RTCRayN_org_x", &RTCRayN_org_x(ray, N, I));
  PLACE("RTCRayN_org_y", &RTCRayN_org_y(ray, N, I));
  PLACE("RTCRayN_org_z", &RTCRayN_org_z(ray, N, I));
  PLACE("RTCRayN_tnear", &RTCRayN_tnear(ray, N, I));
  PLACE("RTCRayN_dir_x", &RTCRayN_dir_x(ray, N, I));
  PLACE("RTCRayN_dir_y", &RTCRayN_dir_y(ray, N, I));
  PLACE("RTCRayN_dir_z", &RTCRayN_dir_z(ray, N, I));
  PLACE("RTCRayN_time", &RTCRayN_time(ray, N, I));
  PLACE("RTCRayN_tfar", &RTCRayN_tfar(ray, N, I));
  PLACE("RTCRayN_mask", &RTCRayN_mask(ray, N, I));
  PLACE("RTCRayN_id", &RTCRayN_id(ray, N, I));
  PLACE("RTCHitN_Ng_x", &RTCHitN_Ng_x(hit, N, I));
  PLACE("RTCHitN_Ng_y", &RTCHitN_Ng_y(hit, N, I));
  PLACE("RTCHitN_Ng_z", &RTCHitN_Ng_z(hit, N, I));
  PLACE("RTCHitN_u", &RTCHitN_u(hit, N, I));
  PLACE("RTCHitN_v", &RTCHitN_v(hit, N, I));
  PLACE("RTCHitN_primID", &RTCHitN_primID(hit, N, I));
  PLACE("RTCHitN_geomID", &RTCHitN_geomID(hit, N, I));
  PLACE("RTCHitN_instID", &RTCHitN_instID(hit, N, I, 0));
  PLACE("RTCHitN_instPrimID", &RTCHitN_instPrimID(hit, N, I, 0));
  PLACE("RTCRayHitN_HitN", RTCRayHitN_HitN((struct RTCRayHitN *)rows, N));
#endif
  return 0;
}
