{{/* What the pods have in common. Most take {root, component, of}: `of` are the component's values. */}}

{{- define "meshgauge.podSecurity" -}}
runAsNonRoot: true
seccompProfile: {type: RuntimeDefault}
{{- with .Values.podSecurityContext }}
{{ toYaml . }}
{{- end }}
{{- end }}

{{/* The readers of uploads confine themselves further: no_new_privs, no capabilities, a seccomp filter of their own. */}}
{{- define "meshgauge.containerSecurity" -}}
allowPrivilegeEscalation: false
readOnlyRootFilesystem: true
capabilities: {drop: [ALL]}
{{- end }}

{{/* Takes {root, of}: `of` names the secret with the connection string. */}}
{{- define "meshgauge.databaseEnv" -}}
- name: MESHGAUGE_DATABASE
  valueFrom:
    secretKeyRef: {name: {{ .of.existingSecret | quote }}, key: {{ .of.key | quote }}}
{{- if .root.Values.database.caSecret }}
- {name: PGSSLROOTCERT, value: {{ printf "/etc/meshgauge/database/%s" .root.Values.database.caKey | quote }}}
{{- end }}
{{- end }}

{{- define "meshgauge.databaseVolume" -}}
{{- with .root.Values.database.caSecret }}
- name: database-ca
  secret: {secretName: {{ . | quote }}, defaultMode: 0440}
{{- end }}
{{- end }}

{{- define "meshgauge.databaseMount" -}}
{{- if .root.Values.database.caSecret }}
- {name: database-ca, mountPath: /etc/meshgauge/database, readOnly: true}
{{- end }}
{{- end }}

{{- define "meshgauge.blobsEnv" -}}
{{- with .Values.blobs }}
- {name: MESHGAUGE_BLOBS, value: {{ .url | quote }}}
- {name: MESHGAUGE_S3_REGION, value: {{ .s3.region | quote }}}
- {name: MESHGAUGE_S3_VIRTUAL_HOST, value: {{ .s3.virtualHost | quote }}}
{{- with .s3.endpoint }}
- {name: MESHGAUGE_S3_ENDPOINT, value: {{ . | quote }}}
{{- end }}
- name: AWS_ACCESS_KEY_ID
  valueFrom:
    secretKeyRef: {name: {{ .s3.existingSecret | quote }}, key: {{ .s3.accessKeyIdKey | quote }}}
- name: AWS_SECRET_ACCESS_KEY
  valueFrom:
    secretKeyRef: {name: {{ .s3.existingSecret | quote }}, key: {{ .s3.secretAccessKeyKey | quote }}}
{{- if .s3.sessionTokenKey }}
- name: AWS_SESSION_TOKEN
  valueFrom:
    secretKeyRef: {name: {{ .s3.existingSecret | quote }}, key: {{ .s3.sessionTokenKey | quote }}}
{{- end }}
{{- end }}
{{- end }}

{{/* Numbers of a values file are doubles, which would print 1e+09. */}}
{{- define "meshgauge.settingsEnv" -}}
{{- $settings := mergeOverwrite (deepCopy .root.Values.settings) .of.settings }}
{{- range $name, $value := $settings }}
- name: MESHGAUGE_{{ upper $name }}
  value: {{ if kindIs "float64" $value }}{{ printf "%.0f" $value | quote }}{{ else }}{{ $value | quote }}{{ end }}
{{- end }}
{{- end }}

{{- define "meshgauge.env" -}}
{{- $values := .root.Values -}}
{{ include "meshgauge.databaseEnv" (dict "root" .root "of" $values.database) }}
{{- if include "meshgauge.usesS3" .root }}
{{ include "meshgauge.blobsEnv" .root }}
{{- end }}
- {name: MESHGAUGE_HOST, value: "0.0.0.0"}
- {name: MESHGAUGE_PORT, value: "8080"}
- {name: MESHGAUGE_WORKERS, value: {{ .of.workers | quote }}}
- {name: MESHGAUGE_GRACE_MS, value: {{ mul .of.graceSeconds 1000 | quote }}}
- {name: MESHGAUGE_TEMP_DIR, value: /tmp}
- {name: MESHGAUGE_DATA_DIR, value: /var/lib/meshgauge/own}
{{- if $values.keys.existingSecret }}
- {name: MESHGAUGE_KEYS_FILE, value: {{ printf "/etc/meshgauge/keys/%s" $values.keys.key | quote }}}
{{- else }}
- {name: MESHGAUGE_PUBLIC_WITHOUT_KEYS, value: "true"}
{{- end }}
{{- include "meshgauge.settingsEnv" . }}
{{- end }}

{{- define "meshgauge.volumes" -}}
- name: tmp
  emptyDir: {{ toYaml .of.tmp | nindent 4 }}
- name: data
  emptyDir: {{ toYaml .of.data | nindent 4 }}
{{- with .root.Values.keys }}
{{- if .existingSecret }}
- name: keys
  secret: {secretName: {{ .existingSecret | quote }}, defaultMode: 0440}
{{- end }}
{{- end }}
{{- with include "meshgauge.databaseVolume" . }}
{{ . }}
{{- end }}
{{- end }}

{{- define "meshgauge.mounts" -}}
- {name: tmp, mountPath: /tmp}
- {name: data, mountPath: /var/lib/meshgauge}
{{- if .root.Values.keys.existingSecret }}
- {name: keys, mountPath: /etc/meshgauge/keys, readOnly: true}
{{- end }}
{{- with include "meshgauge.databaseMount" . }}
{{ . }}
{{- end }}
{{- end }}

{{/* A pod that cannot take work is left alone; one that does not answer is started again. Takes the scheme. */}}
{{- define "meshgauge.probes" -}}
startupProbe:
  httpGet: {path: /healthz, port: http, scheme: {{ . }}}
  periodSeconds: 2
  timeoutSeconds: 3
  failureThreshold: 60
livenessProbe:
  httpGet: {path: /healthz, port: http, scheme: {{ . }}}
  periodSeconds: 10
  timeoutSeconds: 5
  failureThreshold: 6
readinessProbe:
  httpGet: {path: /readyz, port: http, scheme: {{ . }}}
  periodSeconds: 5
  timeoutSeconds: 3
  failureThreshold: 2
{{- end }}

{{- define "meshgauge.placing" -}}
{{- with .of.nodeSelector }}
nodeSelector: {{ toYaml . | nindent 2 }}
{{- end }}
{{- with .of.tolerations }}
tolerations: {{ toYaml . | nindent 2 }}
{{- end }}
{{- with .of.affinity }}
affinity: {{ toYaml . | nindent 2 }}
{{- end }}
{{- with .of.priorityClassName }}
priorityClassName: {{ . | quote }}
{{- end }}
topologySpreadConstraints:
{{- if .of.topologySpreadConstraints }}
{{ toYaml .of.topologySpreadConstraints | indent 2 }}
{{- else }}
{{- $selector := include "meshgauge.selector" . }}
{{- range list "kubernetes.io/hostname" "topology.kubernetes.io/zone" }}
  - maxSkew: 1
    topologyKey: {{ . }}
    whenUnsatisfiable: ScheduleAnyway
    labelSelector:
      matchLabels: {{ $selector | nindent 8 }}
{{- end }}
{{- end }}
{{- end }}

{{/* Service links are off: a Service called meshgauge would set MESHGAUGE_PORT to its address. */}}
{{- define "meshgauge.podBegin" -}}
automountServiceAccountToken: false
enableServiceLinks: false
{{- with .Values.imagePullSecrets }}
imagePullSecrets: {{ toYaml . | nindent 2 }}
{{- end }}
securityContext: {{ include "meshgauge.podSecurity" . | nindent 2 }}
{{- end }}

{{- define "meshgauge.podMetadata" -}}
labels:
  {{- include "meshgauge.labels" . | nindent 2 }}
  {{- with .of.podLabels }}
  {{- toYaml . | nindent 2 }}
  {{- end }}
{{- with .of.podAnnotations }}
annotations: {{ toYaml . | nindent 2 }}
{{- end }}
{{- end }}
