{{/* Names and labels. */}}
{{- define "meshgauge.name" -}}
{{- default .Chart.Name .Values.nameOverride | trunc 40 | trimSuffix "-" }}
{{- end }}

{{- define "meshgauge.fullname" -}}
{{- if .Values.fullnameOverride }}
{{- .Values.fullnameOverride | trunc 40 | trimSuffix "-" }}
{{- else if contains (include "meshgauge.name" .) .Release.Name }}
{{- .Release.Name | trunc 40 | trimSuffix "-" }}
{{- else }}
{{- printf "%s-%s" .Release.Name (include "meshgauge.name" .) | trunc 40 | trimSuffix "-" }}
{{- end }}
{{- end }}

{{/* What never changes of a pod: takes {root, component}. */}}
{{- define "meshgauge.selector" -}}
app.kubernetes.io/name: {{ include "meshgauge.name" .root }}
app.kubernetes.io/instance: {{ .root.Release.Name }}
{{- with .component }}
app.kubernetes.io/component: {{ . }}
{{- end }}
{{- end }}

{{- define "meshgauge.labels" -}}
{{ include "meshgauge.selector" . }}
app.kubernetes.io/version: {{ .root.Chart.AppVersion | quote }}
app.kubernetes.io/managed-by: {{ .root.Release.Service }}
helm.sh/chart: {{ printf "%s-%s" .root.Chart.Name .root.Chart.Version | replace "+" "_" }}
{{- with .root.Values.commonLabels }}
{{ toYaml . }}
{{- end }}
{{- end }}

{{- define "meshgauge.image" -}}
{{- with .Values.image }}
{{- if .digest }}{{ .repository }}@{{ .digest }}{{ else }}{{ .repository }}:{{ default $.Chart.AppVersion .tag }}{{ end }}
{{- end }}
{{- end }}

{{- define "meshgauge.serviceAccount" -}}
{{- if .Values.serviceAccount.create }}
{{- default (include "meshgauge.fullname" .) .Values.serviceAccount.name }}
{{- else }}
{{- default "default" .Values.serviceAccount.name }}
{{- end }}
{{- end }}

{{- define "meshgauge.usesS3" -}}
{{- if hasPrefix "s3://" .Values.blobs.url }}yes{{ end }}
{{- end }}

{{- define "meshgauge.scheme" -}}
{{- if .Values.frontend.tls.existingSecret }}HTTPS{{ else }}HTTP{{ end }}
{{- end }}

{{/* What the schema cannot say. */}}
{{- define "meshgauge.check" -}}
{{- if not .Values.database.existingSecret }}
{{- fail "database.existingSecret: name the Secret that holds PostgreSQL's connection string" }}
{{- end }}
{{- if and (not .Values.keys.existingSecret) (not .Values.keys.publicWithoutKeys) }}
{{- fail "keys: name the Secret of the keys file (keys.existingSecret), or say keys.publicWithoutKeys" }}
{{- end }}
{{- if and (include "meshgauge.usesS3" .) (not .Values.blobs.s3.existingSecret) }}
{{- fail "blobs.s3.existingSecret: name the Secret that holds the credentials of S3" }}
{{- end }}
{{- if and .Values.ingress.enabled (not .Values.ingress.hosts) }}
{{- fail "ingress.hosts: name at least one" }}
{{- end }}
{{- if and .Values.keda.enabled (lt (int .Values.keda.maxReplicas) (int .Values.keda.minReplicas)) }}
{{- fail "keda.maxReplicas is less than keda.minReplicas" }}
{{- end }}
{{- end }}
